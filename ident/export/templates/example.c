/* Steps the model through test_vectors.csv, and compares its torque with that in the file.

   cc -std=c99 -O2 example.c delta_model.c -lm -o example && ./example test_vectors.csv */
#include "delta_model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LONGEST_LINE 8192
#define COLUMNS (1 + 4 * DELTA_MODEL_DOF) /* time, position, velocity, acceleration, torque */

static int read_row(FILE *file, double row[COLUMNS])
{
    static char line[LONGEST_LINE];
    if (!fgets(line, sizeof line, file)) return 0;
    char *cell = line;
    for (int k = 0; k < COLUMNS; k++) {
        char *end;
        row[k] = strtod(cell, &end);
        if (end == cell) return 0;
        cell = end + 1;
    }
    return 1;
}

int main(int count, char **arguments)
{
    static char header[LONGEST_LINE];
    static delta_model_state state;
    const int n = DELTA_MODEL_DOF;
    double row[COLUMNS], last = 0, worst = 0, largest = 0;
    int rows = 0;
    FILE *file = fopen(count > 1 ? arguments[1] : "test_vectors.csv", "r");
    if (!file || !fgets(header, sizeof header, file)) return fprintf(stderr, "no test vectors\n"), 2;
    delta_model_init(&state);
{%- if needs_temperature %}
    {{ real }} celsius[DELTA_MODEL_DOF];
    for (int i = 0; i < n; i++) celsius[i] = {{ temperature }};
    delta_model_temperature(&state, celsius);
{%- endif %}
    for (; read_row(file, row); rows++, last = row[0]) {
        {{ real }} q[DELTA_MODEL_DOF], qd[DELTA_MODEL_DOF], qdd[DELTA_MODEL_DOF], tau[DELTA_MODEL_DOF];
        for (int i = 0; i < n; i++) {
            q[i] = ({{ real }})row[1 + i];
            qd[i] = ({{ real }})row[1 + n + i];
            qdd[i] = ({{ real }})row[1 + 2 * n + i];
        }
        delta_model_torque(&state, q, qd, qdd, ({{ real }})(rows ? row[0] - last : 0), tau);
        for (int i = 0; i < n; i++) {
            worst = fmax(worst, fabs((double)tau[i] - row[1 + 3 * n + i]));
            largest = fmax(largest, fabs(row[1 + 3 * n + i]));
        }
    }
    fclose(file);
    printf("%d rows, largest torque %g, largest difference %g\n", rows, largest, worst);
    return rows && worst <= {{ tolerance }} * largest ? 0 : 1;
}
