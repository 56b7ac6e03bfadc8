/* The number that a file in the resources holds */
#define BIRTH
#include "foreign.h"

static int birth(Model *m, int events, int early) {
    char path[440];
    int found = 0;
    snprintf(path, sizeof path, "%snumber.txt", m->resources);
    FILE *file = fopen(path, "r");
    if (!file || fscanf(file, "%d", &found) != 1) return say(m, 3, "number.txt cannot be read");
    fclose(file);
    m->v[number] = found;
    return 0;
}
static int calculate(Model *m) { return (void)m, 0; }
static int advance(Model *m, double t, double h) { return (void)m, 0; }
