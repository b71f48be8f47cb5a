/* Checks for signals while the core runs: Ctrl-C ends a call within some hundredths of a second. */
#include "python/binding.h"

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

static int check(void *data)
{
    signal_check *signals = data;
    if (seconds_now() < signals->next) {
        return 0;
    }
    const int released = signals->thread != NULL;
    if (released) {
        signal_check_regain(signals);
    }
    const int stop = PyErr_Occurred() || PyErr_CheckSignals() != 0;
    if (released) {
        signal_check_release(signals);
    }
    signals->next = seconds_now() + SIGNAL_INTERVAL;
    return stop;
}

void signal_check_open(signal_check *signals)
{
    *signals = (signal_check){{check, signals}, seconds_now() + SIGNAL_INTERVAL, NULL};
}

void signal_check_release(signal_check *signals)
{
    signal_check_open(signals);
    signals->thread = PyEval_SaveThread();
}

void signal_check_regain(signal_check *signals)
{
    PyEval_RestoreThread(signals->thread);
    signals->thread = NULL;
}

void run_pieces(signal_check *signals, int (*piece)(void *job), void *job)
{
    for (int more = 1; more && !PyErr_Occurred() && PyErr_CheckSignals() == 0;) {
        const double until = seconds_now() + SIGNAL_INTERVAL;
        signal_check_release(signals);
        do {
            more = piece(job);
        } while (more && seconds_now() < until);
        signal_check_regain(signals);
    }
}
