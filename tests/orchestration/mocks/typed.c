/* parameters of several types: y = sum of matrix + n + flag / 2, whole = n */
#include "mock.h"

static int calculate(Mock *m) {
    m->v[whole] = m->v[n];
    m->v[y] = m->v[n] + m->v[flag] / 2;
    for (int i = 0; i < 6; ++i) m->v[y] += m->v[matrix + i];
    return 0;
}
static int step(Mock *m, double t, double h) { return 0; }
static int update(Mock *m) { return 0; }
