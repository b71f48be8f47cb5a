/* Many impacts in one call, without the GIL: of each only its numbers come back. */
#include "python/binding.h"
#include "model/coupled.h"
#include "motion/response.h"
#include "collocation/collocation.h"
#include "adaptive/adaptive.h"
#include "track/brief.h"
#include "track/sampler.h"

#include <stdlib.h>
#include <string.h>

/* Columns of a case, and of its answer. */
enum { CASE_VELOCITY = 0, CASE_GAP, CASE_DURATION, CASE_RTOL, CASE_COLUMNS };
enum {
    ANSWER_STATUS = 0,
    ANSWER_TOUCHES,
    ANSWER_LASTING,
    ANSWER_PEAK_FORCE,
    ANSWER_PEAK_TIME,
    ANSWER_IMPULSE,
    ANSWER_START,
    ANSWER_END,
    ANSWER_VELOCITIES,
    ANSWER_COLUMNS = ANSWER_VELOCITIES + 2
};

/* A contact takes some hundred rows; what needs more is made elsewhere, with room that grows. */
enum { MOST_ROWS = 1024 };

/* Bodies, each with its velocities x' of unit speed, and laws: of these the cases are put together. */
typedef struct stock {
    size_t body_count, law_count;
    aoi_modes *body;
    const double **moving;
    aoi_law *law;
} stock;

/* One case at a time is made on it; work grows with the largest so far. */
typedef struct bench {
    aoi_system system;
    aoi_modes pair[2];
    aoi_joint joint;
    size_t first[3], first_port[3], first_joint[3], joint_of[2];
    aoi_follower follower[2];
    aoi_contact_state contact;
    aoi_stage stage;
    aoi_contact balanced;
    aoi_response response[2];
    size_t place[6], lists[7], index[MOST_ROWS];
    double *work;
    size_t work_count;
} bench;

static int take_stock(held *buffers, PyObject *bodies, PyObject *moving, PyObject *laws, stock *of)
{
    int status = AOI_OK;
    of->body_count = (size_t)PyTuple_Size(bodies);
    of->law_count = (size_t)PyTuple_Size(laws);
    of->body = calloc(of->body_count + 1, sizeof *of->body);
    of->moving = calloc(of->body_count + 1, sizeof *of->moving);
    of->law = calloc(of->law_count + 1, sizeof *of->law);
    if (!of->body || !of->moving || !of->law) {
        buffers->failed = 1;
        PyErr_NoMemory();
        return AOI_OK;
    }
    need_tuple(buffers, moving, (Py_ssize_t)of->body_count);
    for (size_t b = 0; b < of->body_count && !buffers->failed; b++) {
        take_modes(buffers, PyTuple_GetItem(bodies, (Py_ssize_t)b), &of->body[b]);
        size_t n = of->body[b].n;
        of->moving[b] = doubles(buffers, PyTuple_GetItem(moving, (Py_ssize_t)b), "moving", &n);
        status = of->body[b].ports == 1 ? status : AOI_ERROR_ARGUMENT;
    }
    for (size_t c = 0; c < of->law_count && !buffers->failed && status == AOI_OK; c++) {
        status = take_law(buffers, PyTuple_GetItem(laws, (Py_ssize_t)c), &of->law[c]);
    }
    return status;
}

/* AOI_ERROR_ARGUMENT where a case names what is not in stock. */
static int check_cases(const stock *of, size_t count, const int32_t *which)
{
    for (size_t i = 0; i < 3 * count; i++) {
        const size_t most = i % 3 == 2 ? of->law_count : of->body_count;
        if (which[i] < 0 || (size_t)which[i] >= most) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    return AOI_OK;
}

/* Puts a case's bodies together; 0 where there is no memory for them. */
static int set_up(bench *on, const stock *of, const int32_t *which, const double *numbers,
                  aoi_adaptive *run, aoi_sampler *sampler, double **track, size_t *capacity)
{
    size_t needed, lists, row;
    memset(on->follower, 0, sizeof on->follower);
    memset(&on->contact, 0, sizeof on->contact);
    on->first[0] = on->first_port[0] = 0;
    for (size_t b = 0; b < 2; b++) {
        on->pair[b] = of->body[which[b]];
        on->first[b + 1] = on->first[b] + on->pair[b].n;
        on->first_port[b + 1] = b + 1;
    }
    on->joint = (aoi_joint){{0, 1}, {0, 0}, numbers[CASE_GAP], &of->law[which[2]]};
    on->system = (aoi_system){.body_count = 2, .joint_count = 1, .body = on->pair, .joint = &on->joint};
    on->system.first = on->first;
    on->system.first_port = on->first_port;
    (void)aoi_system_link(&on->system, on->first_joint, on->joint_of);
    aoi_adaptive_size(&on->system, &needed, &lists, &row);
    const size_t n = on->first[2], sampling = aoi_sampler_size(&on->system);
    const size_t rows = aoi_sampler_rows(&on->system);
    *capacity = row + MOST_ROWS * row / 4; /* most rows hold one contact and less than all */
    const size_t all = 2 * n + needed + sampling + rows + *capacity;
    if (all > on->work_count) {
        double *larger = realloc(on->work, all * sizeof(double));
        if (!larger) {
            return 0;
        }
        on->work = larger;
        on->work_count = all;
    }
    *run = (aoi_adaptive){.system = &on->system, .rtol = numbers[CASE_RTOL]};
    run->end = numbers[CASE_DURATION];
    run->x = on->work;
    run->v = run->x + n;
    run->work = run->v + n;
    run->body = on->follower;
    run->contact = &on->contact;
    run->stage = &on->stage;
    run->balanced = &on->balanced;
    run->response = on->response;
    run->lists = on->lists;
    *sampler = (aoi_sampler){.system = &on->system, .work = run->work + needed};
    sampler->body_row = on->place;
    sampler->body_at = on->place + 2;
    sampler->contact_row = on->place + 4;
    sampler->contact_at = on->place + 5;
    *track = sampler->work + sampling + rows;
    for (size_t j = 0; j < n; j++) {
        run->x[j] = 0.0;
        run->v[j] = j < on->first[1] ? numbers[CASE_VELOCITY] * of->moving[which[0]][j] : 0.0;
    }
    return 1;
}

/* 0 where there is no memory. */
static int make_case(bench *on, const stock *of, const int32_t *which, const double *numbers,
                     double *answer)
{
    aoi_adaptive run;
    aoi_sampler sampler;
    aoi_brief brief;
    double *track;
    size_t capacity;
    if (!set_up(on, of, which, numbers, &run, &sampler, &track, &capacity)) {
        return 0;
    }
    double *record = track - aoi_sampler_rows(&on->system);
    const int status =
        aoi_brief_run(&run, capacity, MOST_ROWS, track, on->index, &sampler, record, &brief);
    answer[ANSWER_STATUS] = (double)status;
    if (status != AOI_OK) {
        return 1;
    }
    answer[ANSWER_TOUCHES] = (double)brief.touches;
    answer[ANSWER_LASTING] = (double)brief.lasting;
    answer[ANSWER_PEAK_FORCE] = brief.peak_force;
    answer[ANSWER_PEAK_TIME] = brief.peak_time;
    answer[ANSWER_IMPULSE] = brief.impulse;
    answer[ANSWER_START] = brief.start;
    answer[ANSWER_END] = brief.end;
    answer[ANSWER_VELOCITIES] = brief.velocity[0];
    answer[ANSWER_VELOCITIES + 1] = brief.velocity[1];
    return 1;
}

static int make_all(const stock *of, size_t count, const int32_t *which, const double *numbers,
                    double *answers)
{
    bench *on = calloc(1, sizeof *on);
    int fine = on != NULL;
    for (size_t i = 0; fine && i < count && !PyErr_Occurred() && PyErr_CheckSignals() == 0;) {
        const double until = seconds_now() + HEARD_EVERY;
        Py_BEGIN_ALLOW_THREADS
        for (; fine && i < count && seconds_now() < until; i++) {
            fine = make_case(on, of, which + 3 * i, numbers + CASE_COLUMNS * i,
                             answers + ANSWER_COLUMNS * i);
        }
        Py_END_ALLOW_THREADS
    }
    free(on ? on->work : NULL);
    free(on);
    return fine;
}

/* (bodies, moving, laws, which (count, 3), numbers (count, 4), answers (count, 10)) */
PyObject *briefs(PyObject *self, PyObject *args)
{
    PyObject *bodies, *moving, *laws, *which_in, *numbers_in, *answers_out;
    held buffers = {.failed = 0};
    stock of = {.body = NULL};
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!O!OOO", &PyTuple_Type, &bodies, &PyTuple_Type, &moving,
                          &PyTuple_Type, &laws, &which_in, &numbers_in, &answers_out)) {
        return NULL;
    }
    size_t values = (size_t)-1;
    double *answers = doubles_out(&buffers, answers_out, "answers", &values);
    const size_t count = buffers.failed ? 0 : values / ANSWER_COLUMNS;
    size_t triples = 3 * count, quadruples = CASE_COLUMNS * count;
    const int32_t *which = integers(&buffers, which_in, "which", &triples);
    const double *numbers = doubles(&buffers, numbers_in, "numbers", &quadruples);
    int status = take_stock(&buffers, bodies, moving, laws, &of);
    if (!buffers.failed && status == AOI_OK) {
        status = values % ANSWER_COLUMNS == 0 ? check_cases(&of, count, which) : AOI_ERROR_ARGUMENT;
    }
    if (!buffers.failed && status == AOI_OK && !make_all(&of, count, which, numbers, answers)) {
        PyErr_NoMemory();
    }
    free(of.body);
    free((void *)of.moving);
    free(of.law);
    PyObject *done = finish(&buffers, status, "many impacts");
    if (done && PyErr_Occurred()) {
        Py_DECREF(done);
        return NULL;
    }
    return done;
}
