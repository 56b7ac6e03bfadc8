/* Sums up a discrete input, which only event mode may take */
#define BIRTH
#define UPDATE
#include "foreign.h"

static int birth(Model *m, int events, int early) { return events ? 0 : say(m, 3, "this model needs event mode"); }
static int calculate(Model *m) {
    m->v[odd] = (int)m->v[n] % 2;
    return 0;
}
static int advance(Model *m, double t, double h) { return (void)m, 0; }
static void update(Model *m) { m->v[sum] += m->v[n]; }
