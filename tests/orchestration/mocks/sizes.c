/* y = 2 u and the sum of u, of a length that a structural parameter says */
#define RESIZED
#define SIZE m->v[n]
#include "foreign.h"

static int calculate(Model *m) {
    m->v[total] = 0;
    for (int i = 0; i < (int)m->v[n]; ++i) {
        m->v[total] += m->v[u + i];
        m->v[y + i] = 2 * m->v[u + i];
    }
    return 0;
}
static int advance(Model *m, double t, double h) { return (void)m, 0; }
static int resized(Model *m) { return m->v[n] > 20 ? say(m, 3, "n is at most 20") : 0; }
