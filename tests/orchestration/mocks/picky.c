/* x' = u by Euler, in steps of at most `longest`: longer ones are begun and discarded; the end is asked for at `stop`,
 * by FMI 2 with a discarded step */
#define SAVABLE
#include "foreign.h"

static int savable(Model *m) { return m->v[unsavable] == 0.0L ? 0 : say(m, 3, "there is no memory for it"); }

static int calculate(Model *m) { return (void)m, 0; }
static int advance(Model *m, double t, double h) {
    if (t + 1e-9 >= m->v[stop]) return m->last = t, m->terminate = 1, m->log3 ? 0 : 2;
    if (h > m->v[longest] * 1.000001L) {
        /* FMI 3 leaves all as it was before; of FMI 2, whoever goes on from here without restoring sees it */
        if (!m->log3) m->v[x] += m->v[longest] * m->v[u];
        m->last = t + (double)m->v[longest];
        return say(m, 2, "the step is too long");
    }
    m->v[x] += h * m->v[u];
    m->v[steps] += 1;
    return 0;
}
