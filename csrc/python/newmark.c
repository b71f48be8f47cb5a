/* Scenes by Newmark's rule, for Python. */
#include "python/binding.h"
#include "linear/sparse.h"
#include "newmark/body.h"
#include "newmark/scene.h"

#include <stdlib.h>

/* One body of a scene with all that it needs to live. */
typedef struct scene_body {
    aoi_body body;
    aoi_star star;
    aoi_modes modes;
    aoi_full full;
    aoi_factors factors;
    double *u, *v; /* initial values in, final values out */
    double *work;
    double step_cost; /* rough nanoseconds */
    signal_check *signals;    /* of the scene */
} scene_body;

static PyObject *item(PyObject *tuple, Py_ssize_t i) { return PyTuple_GetItem(tuple, i); }

/* The last four of a body's tuple: gravity (or None), centre, u, v, of n coordinates each. */
static aoi_body_start take_start(buffer_list *buffers, PyObject *tuple, size_t n, scene_body *one)
{
    const Py_ssize_t at = PyTuple_Size(tuple) - 4;
    aoi_body_start start = {NULL, NULL, NULL, NULL, NULL};
    if (item(tuple, at) != Py_None) {
        start.gravity = doubles(buffers, item(tuple, at), "gravity", &n);
    }
    start.centre = doubles(buffers, item(tuple, at + 1), "centre", &n);
    start.u = one->u = doubles_out(buffers, item(tuple, at + 2), "u", &n);
    start.v = one->v = doubles_out(buffers, item(tuple, at + 3), "v", &n);
    return start;
}

static void *take_memory(buffer_list *buffers, size_t bytes)
{
    void *memory = buffers->failed ? NULL : malloc(bytes + 1);
    if (!buffers->failed && !memory) {
        buffers->failed = 1;
        PyErr_NoMemory();
    }
    return memory;
}

/* ("star", m0, k0, m, k, alpha, beta, gravity, centre, u, v) */
static int take_star(buffer_list *buffers, PyObject *tuple, scene_body *one, const aoi_rule *rule)
{
    size_t n = (size_t)-1;
    aoi_star *star = &one->star;
    star->m0 = PyFloat_AsDouble(item(tuple, 1));
    star->k0 = PyFloat_AsDouble(item(tuple, 2));
    star->m = doubles(buffers, item(tuple, 3), "m", &n);
    star->k = doubles(buffers, item(tuple, 4), "k", &n);
    star->n = n;
    const aoi_rayleigh damping = {PyFloat_AsDouble(item(tuple, 5)),
                                  PyFloat_AsDouble(item(tuple, 6))};
    const aoi_body_start start = take_start(buffers, tuple, n + 1, one);
    one->work = take_memory(buffers, buffers->failed ? 0 : aoi_body_star_size(n) * sizeof(double));
    one->step_cost = 40.0 + 4.0 * (double)n;
    return buffers->failed
               ? AOI_OK
               : aoi_body_start_star(&one->body, star, &damping, rule, &start, one->work);
}

/* ("modal", omega, decay, participation, residual, force or None, gravity, centre, u, v) */
static int take_modal(buffer_list *buffers, PyObject *tuple, scene_body *one, const aoi_rule *rule)
{
    size_t n = (size_t)-1, square = (size_t)-1, ports = 0;
    aoi_modes *modes = &one->modes;
    modes->omega = doubles(buffers, item(tuple, 1), "omega", &n);
    modes->decay = doubles(buffers, item(tuple, 2), "decay", &n);
    modes->residual = doubles(buffers, item(tuple, 4), "residual", &square);
    while (!buffers->failed && ports * ports < square) {
        ports++;
    }
    size_t all = ports * n;
    modes->shape = modes->push = doubles(buffers, item(tuple, 3), "participation", &all);
    modes->n = n;
    modes->ports = ports;
    aoi_body_start start = take_start(buffers, tuple, n, one);
    modes->gravity = start.gravity;
    modes->centre = start.centre;
    if (item(tuple, 5) != Py_None) {
        size_t both = 2 * ports;
        start.force = doubles(buffers, item(tuple, 5), "force", &both);
    }
    one->work = take_memory(buffers, buffers->failed ? 0 : aoi_body_modal_size(n, ports) * sizeof(double));
    one->step_cost = 40.0 + 4.0 * (double)(n * (1 + ports));
    if (buffers->failed || ports * ports != square) {
        return AOI_ERROR_ARGUMENT;
    }
    return aoi_body_start_modal(&one->body, modes, rule, &start, one->work);
}

/* ("full", K, M, b, alpha, beta, factors, gravity, centre, u, v) */
static int take_full(buffer_list *buffers, PyObject *tuple, scene_body *one, const aoi_rule *rule)
{
    aoi_full *full = &one->full;
    size_t rows = (size_t)-1, all = (size_t)-1;
    (void)doubles(buffers, item(tuple, 8), "centre", &rows);
    const double *b = doubles(buffers, item(tuple, 3), "b", &all);
    if (buffers->failed || rows == 0 || all % rows != 0) {
        return AOI_ERROR_ARGUMENT;
    }
    full->b = b;
    full->ports = all / rows;
    const size_t size = aoi_body_full_size(rows, full->ports);
    one->work = take_memory(buffers, (size + rows) * sizeof(double));
    if (buffers->failed) {
        return AOI_OK;
    }
    one->factors.work = one->work + size;
    int status = take_sparse(buffers, item(tuple, 1), rows, &full->K);
    if (status == AOI_OK) {
        status = take_sparse(buffers, item(tuple, 2), rows, &full->M);
    }
    if (status == AOI_OK) {
        status = take_factors(buffers, item(tuple, 6), rows, &one->factors);
    }
    full->damping.alpha = PyFloat_AsDouble(item(tuple, 4));
    full->damping.beta = PyFloat_AsDouble(item(tuple, 5));
    const aoi_body_start start = take_start(buffers, tuple, rows, one);
    if (buffers->failed || status != AOI_OK) {
        return status;
    }
    full->solver = (aoi_solver){aoi_factors_solve, &one->factors};
    one->step_cost = 2.0 * (3.0 * full->K.start[rows] + 2.0 * one->factors.start[rows]);
    full->pause = one->factors.pause = &one->signals->pause;
    signal_check_release(one->signals);
    status = aoi_body_start_full(&one->body, full, rule, &start, one->work);
    signal_check_regain(one->signals);
    return status;
}

static int take_body(buffer_list *buffers, PyObject *tuple, scene_body *one, const aoi_rule *rule)
{
    static const struct {
        const char *kind;
        Py_ssize_t size;
        int (*take)(buffer_list *, PyObject *, scene_body *, const aoi_rule *);
    } kinds[] = {{"star", 11, take_star}, {"modal", 10, take_modal}, {"full", 11, take_full}};
    PyObject *first = PyTuple_Check(tuple) && PyTuple_Size(tuple) > 0 ? item(tuple, 0) : Py_None;
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (PyUnicode_Check(first) && PyUnicode_CompareWithASCIIString(first, kinds[i].kind) == 0) {
            need_tuple(buffers, tuple, kinds[i].size);
            return buffers->failed ? AOI_OK : kinds[i].take(buffers, tuple, one, rule);
        }
    }
    if (!buffers->failed) {
        buffers->failed = 1;
        PyErr_SetString(PyExc_TypeError,
                        "a body is a tuple that begins with \"star\", \"modal\" or \"full\"");
    }
    return AOI_OK;
}

/* (body, port, times, forces) */
static void take_load(buffer_list *buffers, PyObject *tuple, aoi_scene_load *load)
{
    size_t count = (size_t)-1;
    need_tuple(buffers, tuple, 4);
    if (buffers->failed) {
        return;
    }
    load->body = PyLong_AsSize_t(item(tuple, 0));
    load->port = PyLong_AsSize_t(item(tuple, 1));
    load->ports = 1;
    load->load.time = doubles(buffers, item(tuple, 2), "times of a load", &count);
    load->load.force = doubles(buffers, item(tuple, 3), "forces of a load", &count);
    load->load.count = count;
}

/* All that a scene is made of. */
typedef struct scene_parts {
    scene_body *body_of;
    aoi_body **body;
    aoi_contact *contact;
    aoi_law *law;
    aoi_scene_load *load;
    aoi_scene scene;
    double step_cost;
    signal_check signals;
} scene_parts;

static void parts_release(scene_parts *all, int copy)
{
    for (size_t b = 0; all->body_of && b < all->scene.body_count; b++) {
        scene_body *one = &all->body_of[b];
        if (copy) {
            one->body.copy_state(&one->body, one->u, one->v);
        }
        free(one->work);
    }
    free(all->body_of);
    free(all->body);
    free(all->contact);
    free(all->law);
    free(all->load);
    free(all->scene.memory);
    free(all->scene.first_port);
}

static int parts_allocate(scene_parts *all)
{
    const aoi_scene *scene = &all->scene;
    all->body_of = calloc(scene->body_count + 1, sizeof *all->body_of);
    all->body = calloc(scene->body_count + 1, sizeof *all->body);
    all->contact = calloc(scene->contact_count + 1, sizeof *all->contact);
    all->law = calloc(scene->contact_count + 1, sizeof *all->law);
    all->load = calloc(scene->load_count + 1, sizeof *all->load);
    all->scene.first_port = calloc(scene->body_count + 1, sizeof *scene->first_port);
    if (!all->body_of || !all->body || !all->contact || !all->law || !all->load ||
        !scene->first_port) {
        PyErr_NoMemory();
        return 0;
    }
    return 1;
}

/* Bodies, contacts and loads from their tuples. */
static int parts_take(buffer_list *buffers, scene_parts *all, PyObject *bodies, PyObject *contacts,
                     PyObject *loads, const aoi_rule *rule)
{
    aoi_scene *scene = &all->scene;
    int status = AOI_OK;
    signal_check_open(&all->signals);
    for (size_t b = 0; b < scene->body_count && status == AOI_OK && !buffers->failed; b++) {
        scene_body *one = &all->body_of[b];
        one->signals = &all->signals;
        status = take_body(buffers, item(bodies, (Py_ssize_t)b), one, rule);
        all->body[b] = &one->body;
        all->step_cost += one->step_cost;
    }
    for (size_t c = 0; c < scene->contact_count && status == AOI_OK && !buffers->failed; c++) {
        status = take_contact(buffers, item(contacts, (Py_ssize_t)c), &all->contact[c],
                              &all->law[c]);
        all->step_cost += 100.0;
    }
    for (size_t i = 0; i < scene->load_count && !buffers->failed; i++) {
        take_load(buffers, item(loads, (Py_ssize_t)i), &all->load[i]);
    }
    scene->body = all->body;
    scene->contact = all->contact;
    scene->load = all->load;
    buffers->failed = buffers->failed || PyErr_Occurred();
    if (status == AOI_OK && !buffers->failed) {
        status = aoi_scene_check(scene);
    }
    if (status == AOI_OK) {
        scene->memory = take_memory(buffers, buffers->failed ? 0 : aoi_scene_size(scene));
    }
    return status;
}

/* Runs the steps in chunks without the GIL; between them signals are checked. */
static int run_in_chunks(scene_parts *all, double *record, size_t columns, size_t *done)
{
    const double in_20_ms = 2e7 / all->step_cost;
    const size_t chunk = in_20_ms < 1.0 ? 1 : (size_t)in_20_ms, steps = columns - 1;
    *done = 0;
    signal_check_release(&all->signals);
    int status = aoi_scene_start(&all->scene, record, columns);
    signal_check_regain(&all->signals);
    while (status == AOI_OK && *done < steps) {
        const size_t first = *done + 1;
        const size_t last = steps - *done < chunk ? steps : *done + chunk;
        signal_check_release(&all->signals);
        status = aoi_scene_run(&all->scene, record, columns, first, last, done);
        signal_check_regain(&all->signals);
        if (PyErr_CheckSignals() != 0) {
            break;
        }
    }
    return status;
}

PyObject *newmark_scene(PyObject *self, PyObject *args)
{
    PyObject *bodies, *contacts, *loads, *record_out, *start_force;
    buffer_list buffers = {.failed = 0};
    scene_parts all = {.step_cost = 40.0};
    aoi_rule rule;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!O!dddOpO", &PyTuple_Type, &bodies, &PyTuple_Type, &contacts,
                          &PyTuple_Type, &loads, &rule.dt, &rule.beta, &rule.gamma, &record_out,
                          &all.scene.energies, &start_force)) {
        return NULL;
    }
    aoi_scene *scene = &all.scene;
    size_t values = (size_t)-1, done = 0;
    int status = AOI_OK;
    double *record = doubles_out(&buffers, record_out, "record", &values);
    scene->dt = rule.dt;
    scene->body_count = (size_t)PyTuple_Size(bodies);
    scene->contact_count = (size_t)PyTuple_Size(contacts);
    scene->load_count = (size_t)PyTuple_Size(loads);
    if (start_force != Py_None) {
        size_t count = scene->contact_count;
        scene->start_force = doubles(&buffers, start_force, "start_force", &count);
    }
    buffers.failed = buffers.failed || !parts_allocate(&all);
    if (!buffers.failed) {
        status = parts_take(&buffers, &all, bodies, contacts, loads, &rule);
    }
    if (!buffers.failed && status == AOI_OK) {
        const size_t rows = aoi_scene_rows(scene), columns = rows > 0 ? values / rows : 0;
        status = columns > 0 && columns * rows == values
                     ? run_in_chunks(&all, record, columns, &done)
                     : AOI_ERROR_ARGUMENT;
    }
    if (!buffers.failed && status != AOI_OK) {
        raise_of_laws(status, "Newmark step", rule.dt * (double)(done + 1), all.law,
                      scene->contact_count, (Py_ssize_t)scene->failed);
    }
    parts_release(&all, !buffers.failed && !PyErr_Occurred());
    buffers_release(&buffers);
    if (buffers.failed || PyErr_Occurred()) {
        return NULL;
    }
    Py_RETURN_NONE;
}
