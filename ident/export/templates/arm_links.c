/* Links of a tree: recursive Newton-Euler in the links' own frames, linear in mass, first moments and inertia.
   Joints stand in an order in which each comes after the one that carries it. */
static const int parent[] = { {{- links.parents -}} };      /* place of the joint below, -1 for the base */
static const int joint[] = { {{- links.joints -}} };        /* its number */
static const int prismatic[] = { {{- links.prismatic -}} };

static void cross(const real a[3], const real b[3], real c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* sum += w x (w x r) + dw x r: the acceleration of a point at r. */
static void add_turning(const real w[3], const real dw[3], const real r[3], real sum[3])
{
    real wr[3], wwr[3], dwr[3];
    cross(w, r, wr);
    cross(w, wr, wwr);
    cross(dw, r, dwr);
    for (int d = 0; d < 3; d++) sum[d] += wwr[d] + dwr[d];
}

/* Rotation R and place p of joint k's frame in the frame of the joint below, at the position q. */
static void frame_of(int k, real q, real R[3][3], real p[3])
{
    const real *axis = axes + 3 * k, *fixed = rotations + 9 * k;
    const real c = prismatic[k] ? 1 : cos(q), s = prismatic[k] ? 0 : sin(q);
    for (int column = 0; column < 3; column++) {
        real unit[3] = {0}, turned[3];
        unit[column] = 1;
        cross(axis, unit, turned);
        for (int d = 0; d < 3; d++) turned[d] = c * unit[d] + s * turned[d] + (1 - c) * axis[column] * axis[d];
        for (int d = 0; d < 3; d++)
            R[d][column] = fixed[3 * d] * turned[0] + fixed[3 * d + 1] * turned[1] + fixed[3 * d + 2] * turned[2];
    }
    for (int d = 0; d < 3; d++) {
        const real along = fixed[3 * d] * axis[0] + fixed[3 * d + 1] * axis[1] + fixed[3 * d + 2] * axis[2];
        p[d] = places[3 * k + d] + (prismatic[k] ? along * q : 0);
    }
}

/* Force f and moment n that move a link with the parameters m, mx, my, mz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz. */
static void load_of(const real *link, const real w[3], const real dw[3], const real a[3], real f[3], real n[3])
{
    const real *h = link + 1;
    const real about[3][3] = { {link[4], link[5], link[7]}, {link[5], link[6], link[8]}, {link[7], link[8], link[9]} };
    real spin[3], lever[3], gyroscopic[3];
    for (int d = 0; d < 3; d++) {
        f[d] = link[0] * a[d];
        spin[d] = about[d][0] * w[0] + about[d][1] * w[1] + about[d][2] * w[2];
    }
    add_turning(w, dw, h, f);
    cross(w, spin, gyroscopic);
    cross(h, a, lever);
    for (int d = 0; d < 3; d++)
        n[d] = about[d][0] * dw[0] + about[d][1] * dw[1] + about[d][2] * dw[2] + gyroscopic[d] + lever[d];
}

/* Torque of links with the parameters `inertial` under gravity, (3,) [m/s^2]; moving 0: at rest. */
static void links_torque(const motion *m, int moving, const real gravity[3], const real *inertial, real torque[DOF])
{
    real R[DOF][3][3], p[DOF][3], w[DOF][3], dw[DOF][3], a[DOF][3], f[DOF][3], n[DOF][3];
    const real still[3] = {0}, lift[3] = {-gravity[0], -gravity[1], -gravity[2]};
    for (int k = 0; k < DOF; k++) {
        const real *axis = axes + 3 * k, *w0 = still, *dw0 = still, *a0 = lift;
        const int j = joint[k];
        const real qd = moving ? m->qd[j] : 0, qdd = moving ? m->qdd[j] : 0;
        if (parent[k] >= 0) w0 = w[parent[k]], dw0 = dw[parent[k]], a0 = a[parent[k]];
        real carried[3] = {a0[0], a0[1], a0[2]}, own[3], turned[3];
        frame_of(k, m->q[j], R[k], p[k]);
        add_turning(w0, dw0, p[k], carried);
        for (int d = 0; d < 3; d++) {
            w[k][d] = R[k][0][d] * w0[0] + R[k][1][d] * w0[1] + R[k][2][d] * w0[2];
            dw[k][d] = R[k][0][d] * dw0[0] + R[k][1][d] * dw0[1] + R[k][2][d] * dw0[2];
            a[k][d] = R[k][0][d] * carried[0] + R[k][1][d] * carried[1] + R[k][2][d] * carried[2];
            own[d] = axis[d] * qd;
        }
        cross(w[k], own, turned);
        for (int d = 0; d < 3; d++) {
            if (prismatic[k]) a[k][d] += axis[d] * qdd + 2 * turned[d];
            else dw[k][d] += axis[d] * qdd + turned[d], w[k][d] += own[d];
        }
        load_of(inertial + 10 * k, w[k], dw[k], a[k], f[k], n[k]);
    }
    for (int k = DOF - 1; k >= 0; k--) {
        const real *axis = axes + 3 * k, *load = prismatic[k] ? f[k] : n[k];
        torque[joint[k]] = axis[0] * load[0] + axis[1] * load[1] + axis[2] * load[2];
        if (parent[k] < 0) continue;
        real passed[3], moment[3];
        for (int d = 0; d < 3; d++) passed[d] = R[k][d][0] * f[k][0] + R[k][d][1] * f[k][1] + R[k][d][2] * f[k][2];
        cross(p[k], passed, moment);
        for (int d = 0; d < 3; d++) {
            f[parent[k]][d] += passed[d];
            n[parent[k]][d] += moment[d] + R[k][d][0] * n[k][0] + R[k][d][1] * n[k][1] + R[k][d][2] * n[k][2];
        }
    }
}

/* Torque of links, motors and constant torques; what effects need of the links; torque of friction. */
static void move_links(motion *m)
{
    links_torque(m, 1, gravity, inertial, m->rigid);
{%- if links.of_tool %}
    links_torque(m, 1, gravity, tool, m->torque_per_mass);
{%- endif %}
{%- if links.of_tilt %}
    for (int d = 0; d < 2; d++) links_torque(m, 0, across + 3 * d, weight, m->sideways[d]);
{%- endif %}
    for (int i = 0; i < DOF; i++) m->friction[i] = 0, m->rigid[i] += offset[i];
    for (int motor = 0; motor < DOF; motor++) {
        const real *turns = coupled + DOF * motor;
        real speed = 0, acceleration = 0;
        int alone = 1;
        for (int i = 0; i < DOF; i++) {
            speed += turns[i] * m->qd[i];
            acceleration += turns[i] * m->qdd[i];
            if (i != motor && turns[i] != 0) alone = 0;
        }
        const real direction = alone ? m->direction[motor] : sign(speed);
        for (int i = 0; i < DOF; i++) {
            m->rigid[i] += turns[i] * motors[motor] * acceleration;
            m->friction[i] += turns[i] * (viscous[motor] * speed + coulomb[motor] * direction);
        }
    }
}
