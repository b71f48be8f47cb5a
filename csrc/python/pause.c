/* Signals are heard while the core works: Ctrl-C within some hundredths of a second. */
#include "python/binding.h"

#include <time.h>

double seconds_now(void)
{
    struct timespec now;
#ifdef _MSC_VER
    (void)timespec_get(&now, TIME_UTC);
#else
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
#endif
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int ask(void *data)
{
    listener *ear = data;
    if (seconds_now() < ear->next) {
        return 0;
    }
    const int released = ear->thread != NULL;
    if (released) {
        listener_regain(ear);
    }
    const int stop = PyErr_Occurred() || PyErr_CheckSignals() != 0;
    if (released) {
        listener_release(ear);
    }
    ear->next = seconds_now() + HEARD_EVERY;
    return stop;
}

void listener_open(listener *ear)
{
    *ear = (listener){{ask, ear}, seconds_now() + HEARD_EVERY, NULL};
}

void listener_release(listener *ear) { ear->thread = PyEval_SaveThread(); }

void listener_regain(listener *ear)
{
    PyEval_RestoreThread(ear->thread);
    ear->thread = NULL;
}
