/* y = u, a square matrix whose size two structural parameters say together; others are no sizes, and are seen */
#define RESIZED
#define SIZE m->v[rows] * m->v[columns]
#include "foreign.h"

static int calculate(Model *m) {
    const int n = (int)(SIZE);
    for (int i = 0; i < n; ++i) m->v[y + i] = m->v[u + i];
    m->v[seen] = m->v[margin];
    m->v[seen + 1] = m->v[deep];
    m->v[seen + 2] = m->v[level];
    m->v[seen + 3] = (long double)m->length[label];
    m->v[entered] = m->count[0];
    return 0;
}
static int advance(Model *m, double t, double h) { return (void)m, 0; }
static int resized(Model *m) {
    ++m->count[0];
    return m->v[rows] != m->v[columns] ? say(m, 3, "rows and columns must be equal") : 0;
}
