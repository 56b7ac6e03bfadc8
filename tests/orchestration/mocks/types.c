/* Every type: outputs show inputs and parameters */
#include "foreign.h"

#define SHOW(T)                \
    m->v[y_##T] = m->v[u_##T]; \
    m->v[q_##T] = m->v[p_##T];

static int calculate(Model *m) {
    SHOW(Float64) SHOW(Float32) SHOW(Int8) SHOW(UInt8) SHOW(Int16) SHOW(UInt16) SHOW(Int32) SHOW(UInt32) SHOW(Int64)
    SHOW(UInt64) SHOW(Boolean)
    m->v[phase_out] = m->v[phase];
    m->v[letters] = (long double)(m->length[word] + m->length[words] + m->length[words + 1]);
    m->v[bytes] = 0;
    for (size_t i = 0; i < m->length[blob]; ++i) m->v[bytes] += (unsigned char)m->text[blob][i];
    return 0;
}
static int advance(Model *m, double t, double h) { return (void)m, 0; }
