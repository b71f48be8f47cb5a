/* Signals are checked while the core runs: Ctrl-C ends a call within some hundredths of a second. */
#include "python/binding.h"

/* Processor time of a piece, s. A row of an adaptive run takes some 0.2 us a mode, and far longer where a touch is hard
 * to exclude. */
static const double SHORT_PIECE = 0.01, LONG_PIECE = 0.05;

size_t piece_after(size_t rows, clock_t began)
{
    const double seconds = (double)(clock() - began) / CLOCKS_PER_SEC;
    if (seconds > LONG_PIECE) {
        return 1 + rows / 4;
    }
    return seconds < SHORT_PIECE && rows <= SIZE_MAX / 2 ? 2 * rows : rows;
}

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

void signal_check_release(signal_check *signals) { signals->thread = PyEval_SaveThread(); }

void signal_check_regain(signal_check *signals)
{
    PyEval_RestoreThread(signals->thread);
    signals->thread = NULL;
}
