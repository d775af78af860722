/* For a C Caller block of Simulink, or the cyclic task of a controller: the model with a state of its own. */
#ifndef MODEL_BLOCK_H
#define MODEL_BLOCK_H

/* Once before the first cycle (in Simulink: Initialize Function of the model). */
void model_block_start(void);

/* In each cycle, dt [s] after the last one: torque tau [N m or N] of the reference q, qd, qdd. */
void model_block(const double q[], const double qd[], const double qdd[], double dt, double tau[]);

#endif
