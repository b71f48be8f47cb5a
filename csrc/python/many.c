/* Python binding of many impacts in one call, without the GIL. The result of each impact is an aoi_brief. */
#include "python/binding.h"
#include "track/brief.h"

#include <stdlib.h>
#include <string.h>

/* Columns of the matrix of cases, and number of columns of the answers: a status and an aoi_brief. */
enum { CASE_VELOCITY = 0, CASE_GAP, CASE_DURATION, CASE_RTOL, CASE_COLUMNS };
enum { ANSWER_COLUMNS = 1 + sizeof(aoi_brief) / sizeof(double) };

/* Largest number of rows of a case's track. A contact takes some hundred rows. A case that needs more fails, and
 * Python runs it alone, with a track that grows. */
enum { MOST_ROWS = 1024 };

/* Bodies, their rates at unit velocity (moving), and laws, which are combined to cases. */
typedef struct cases {
    size_t body_count, law_count;
    aoi_modes *body;
    const double **moving;
    aoi_law *law;
} cases;

/* Work space for one case at a time. `memory` holds the initial rates and the run, and grows to the size that the
 * largest case so far needs. */
typedef struct work {
    aoi_system system;
    aoi_modes pair[2];
    aoi_contact contact;
    void *links;
    double *memory;
    size_t size;
} work;

static void take_cases(call *of, PyObject *bodies, PyObject *moving, PyObject *laws, cases *made)
{
    made->body_count = of->status == AOI_OK ? (size_t)PyTuple_Size(bodies) : 0;
    made->law_count = of->status == AOI_OK ? (size_t)PyTuple_Size(laws) : 0;
    made->body = call_room(of, made->body_count, sizeof *made->body);
    made->moving = call_room(of, made->body_count, sizeof *made->moving);
    made->law = call_room(of, made->law_count, sizeof *made->law);
    for (size_t b = 0; b < made->body_count && of->status == AOI_OK; b++) {
        aoi_modes *body = &made->body[b];
        take_body(of, tuple_item(of, bodies, b, made->body_count), body, NULL, NULL);
        TAKE_SOME(of, moving, b, made->body_count, ARRAY('d', made->moving[b], body->n));
        call_fail(of, body->ports == 1 ? AOI_OK : AOI_ERROR_ARGUMENT);
    }
    for (size_t c = 0; c < made->law_count && of->status == AOI_OK; c++) {
        take_law(of, tuple_item(of, laws, c, made->law_count), &made->law[c]);
    }
}

/* Returns AOI_ERROR_ARGUMENT if a case refers to a body or law that does not exist. */
static int check_cases(const cases *of, size_t count, const int32_t *which)
{
    for (size_t i = 0; i < 3 * count; i++) {
        const size_t most = i % 3 == 2 ? of->law_count : of->body_count;
        if (which[i] < 0 || (size_t)which[i] >= most) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    return AOI_OK;
}

/* Runs one case. which: first body, second body and law; numbers: the CASE_COLUMNS values of the case. */
static int run_case(work *on, const cases *of, const int32_t *which, const double *numbers, aoi_brief *brief)
{
    const double *moving = of->moving[which[0]];
    for (size_t b = 0; b < 2; b++) {
        on->pair[b] = of->body[which[b]];
    }
    on->contact = (aoi_contact){{0, 1}, {0, 0}, numbers[CASE_GAP], &of->law[which[2]], NULL, NULL};
    on->system = (aoi_system){.body_count = 2, .contact_count = 1, .body = on->pair};
    on->system.contact = &on->contact;
    on->links = on->links ? on->links : malloc(aoi_system_size(&on->system));
    const int status = on->links ? aoi_system_link(&on->system, on->links) : CALL_NO_MEMORY;
    if (status != AOI_OK) {
        return status;
    }
    const size_t n = on->system.first[2], rates = n + n % 2; /* even, so that the run behind the rates is aligned */
    const size_t size = rates * sizeof(double) + aoi_brief_size(&on->system, MOST_ROWS);
    double *larger = size > on->size ? realloc(on->memory, size) : on->memory;
    if (!larger) {
        return CALL_NO_MEMORY;
    }
    on->memory = larger;
    on->size = size > on->size ? size : on->size;
    for (size_t j = 0; j < n; j++) {
        on->memory[j] = j < on->system.first[1] ? numbers[CASE_VELOCITY] * moving[j] : 0.0;
    }
    const aoi_start start = {.v = on->memory};
    return aoi_brief_run(&on->system, &start, numbers[CASE_RTOL], numbers[CASE_DURATION], MOST_ROWS,
                         on->memory + rates, brief);
}

/* All cases, of which the first `done` have been run. which, numbers, answers: one row for each case. */
typedef struct job {
    work on;
    const cases *of;
    size_t count, done;
    const int32_t *which;
    const double *numbers;
    double *answers;
    int status;
} job;

static int one_case(void *data)
{
    job *at = data;
    const double *numbers = at->numbers + CASE_COLUMNS * at->done;
    double *answer = at->answers + ANSWER_COLUMNS * at->done;
    aoi_brief brief;
    if (at->done == at->count) {
        return 0;
    }
    const int status = run_case(&at->on, at->of, at->which + 3 * at->done++, numbers, &brief);
    if (status == CALL_NO_MEMORY) {
        at->status = status;
        return 0;
    }
    answer[0] = (double)status;
    if (status == AOI_OK) {
        memcpy(answer + 1, &brief, sizeof brief);
    }
    return 1;
}

/* Runs many impacts. args: (bodies, moving, laws, which (count, 3), numbers (count, 4), answers (count, 10)). */
PyObject *briefs(PyObject *args)
{
    call of = {.status = AOI_OK};
    PyObject *bodies = NULL, *moving = NULL, *laws = NULL;
    cases made = {.body = NULL};
    job at = {.of = &made, .count = ANY_LENGTH};
    signal_check signals;
    size_t three = 3, columns = CASE_COLUMNS, answered = ANSWER_COLUMNS;
    TAKE(&of, args, VALUE('t', bodies), VALUE('t', moving), VALUE('t', laws), MATRIX('i', at.which, at.count, three),
         MATRIX('d', at.numbers, at.count, columns), MATRIX('D', at.answers, at.count, answered));
    take_cases(&of, bodies, moving, laws, &made);
    if (of.status == AOI_OK && (of.status = check_cases(&made, at.count, at.which)) == AOI_OK) {
        run_pieces(&signals, one_case, &at);
        of.status = at.status;
    }
    free(at.on.links);
    free(at.on.memory);
    free(made.body);
    free((void *)made.moving);
    free(made.law);
    return finish(&of, "many impacts", "");
}
