#include "model_block.h"

#include "delta_model.h"

static delta_model_state state;

void model_block_start(void) { delta_model_init(&state); }

void model_block(const double q[], const double qd[], const double qdd[], double dt, double tau[])
{
    int joint;
    delta_model_torque(&state, q, qd, qdd, dt, tau);
    for (joint = 0; joint < DELTA_MODEL_DOF; joint++)
        if (!(tau[joint] == tau[joint])) tau[joint] = 0.0; /* NaN, out of reach: the position loop alone */
}
