/* Scenes by Newmark's rule, for Python. */
#include "python/binding.h"
#include "linear/sparse.h"
#include "linear/work.h"
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
    signal_check *signals; /* of the scene */
} scene_body;

static PyObject *item(PyObject *tuple, Py_ssize_t i) { return PyTuple_GetItem(tuple, i); }

/* A part of a body by its name; NULL, with an error raised, where there is none. */
static PyObject *part(buffer_list *buffers, PyObject *body, const char *name)
{
    PyObject *value = buffers->failed ? NULL : PyDict_GetItemString(body, name);
    if (!value && !buffers->failed) {
        buffers->failed = 1;
        PyErr_Format(PyExc_TypeError, "a body needs \"%s\"", name);
    }
    return value;
}

static double take_number(buffer_list *buffers, PyObject *body, const char *name)
{
    PyObject *value = part(buffers, body, name);
    const double number = value ? PyFloat_AsDouble(value) : 0.0;
    buffers->failed = buffers->failed || PyErr_Occurred();
    return number;
}

static const double *take_array(buffer_list *buffers, PyObject *body, const char *name, size_t *count)
{
    return doubles(buffers, part(buffers, body, name), name, count);
}

/* One that may be None. */
static const double *take_maybe(buffer_list *buffers, PyObject *body, const char *name, size_t *count)
{
    return part(buffers, body, name) == Py_None ? NULL : take_array(buffers, body, name, count);
}

static aoi_rayleigh take_damping(buffer_list *buffers, PyObject *body)
{
    const double alpha = take_number(buffers, body, "alpha");
    return (aoi_rayleigh){alpha, take_number(buffers, body, "beta")};
}

/* What every body has of its n coordinates; u and v are overwritten at the end. */
static aoi_body_start take_start(buffer_list *buffers, PyObject *body, size_t n, scene_body *one)
{
    aoi_body_start start = {.gravity = take_maybe(buffers, body, "gravity", &n)};
    start.centre = take_array(buffers, body, "centre", &n);
    start.u = one->u = doubles_out(buffers, part(buffers, body, "u"), "u", &n);
    start.v = one->v = doubles_out(buffers, part(buffers, body, "v"), "v", &n);
    return start;
}

static void *take_memory(buffer_list *buffers, size_t count, size_t size)
{
    void *memory = buffers->failed ? NULL : malloc(aoi_times(count, size) + 1);
    if (!buffers->failed && !memory) {
        buffers->failed = 1;
        PyErr_NoMemory();
    }
    return memory;
}

static int take_star(buffer_list *buffers, PyObject *body, scene_body *one, const aoi_rule *rule)
{
    size_t n = (size_t)-1;
    aoi_star *star = &one->star;
    star->m0 = take_number(buffers, body, "m0");
    star->k0 = take_number(buffers, body, "k0");
    star->m = take_array(buffers, body, "m", &n);
    star->k = take_array(buffers, body, "k", &n);
    star->n = n;
    const aoi_rayleigh damping = take_damping(buffers, body);
    const aoi_body_start start = take_start(buffers, body, n + 1, one);
    one->work = take_memory(buffers, aoi_body_star_size(n), sizeof(double));
    return buffers->failed
               ? AOI_OK
               : aoi_body_start_star(&one->body, star, &damping, rule, &start, one->work);
}

static int take_modal(buffer_list *buffers, PyObject *body, scene_body *one, const aoi_rule *rule)
{
    size_t n = (size_t)-1, square = (size_t)-1, ports = 0;
    aoi_modes *modes = &one->modes;
    modes->omega = take_array(buffers, body, "omega", &n);
    modes->decay = take_array(buffers, body, "decay", &n);
    modes->residual = take_array(buffers, body, "residual", &square);
    while (!buffers->failed && ports * ports < square) {
        ports++;
    }
    size_t all = ports * n, both = 2 * ports;
    modes->shape = modes->push = take_array(buffers, body, "shape", &all);
    modes->n = n;
    modes->ports = ports;
    aoi_body_start start = take_start(buffers, body, n, one);
    modes->gravity = start.gravity;
    modes->centre = start.centre;
    start.force = take_maybe(buffers, body, "residual_forces", &both);
    one->work = take_memory(buffers, aoi_body_modal_size(n, ports), sizeof(double));
    if (buffers->failed || ports * ports != square) {
        return AOI_ERROR_ARGUMENT;
    }
    return aoi_body_start_modal(&one->body, modes, rule, &start, one->work);
}

static int take_full(buffer_list *buffers, PyObject *body, scene_body *one, const aoi_rule *rule)
{
    aoi_full *full = &one->full;
    size_t rows = (size_t)-1, all = (size_t)-1;
    (void)take_array(buffers, body, "centre", &rows);
    full->b = take_array(buffers, body, "B", &all);
    if (buffers->failed || rows == 0 || all % rows != 0) {
        return AOI_ERROR_ARGUMENT;
    }
    full->ports = all / rows;
    const size_t size = aoi_body_full_size(rows, full->ports);
    one->work = take_memory(buffers, size + rows, sizeof(double));
    PyObject *K = part(buffers, body, "K"), *M = part(buffers, body, "M");
    PyObject *factors = part(buffers, body, "factors");
    full->damping = take_damping(buffers, body);
    const aoi_body_start start = take_start(buffers, body, rows, one);
    if (buffers->failed) {
        return AOI_OK;
    }
    one->factors.work = one->work + size;
    int status = take_sparse(buffers, K, rows, &full->K);
    if (status == AOI_OK) {
        status = take_sparse(buffers, M, rows, &full->M);
    }
    if (status == AOI_OK) {
        status = take_factors(buffers, factors, rows, &one->factors);
    }
    if (buffers->failed || status != AOI_OK) {
        return status;
    }
    full->solver = (aoi_solver){aoi_factors_solve, &one->factors};
    full->pause = one->factors.pause = &one->signals->pause;
    signal_check_release(one->signals);
    status = aoi_body_start_full(&one->body, full, rule, &start, one->work);
    signal_check_regain(one->signals);
    return status;
}

/* A dict of a body's parts by name, "kind" among them; see SteppedBody in aoimpact/scene/stepped.py. */
static int take_body(buffer_list *buffers, PyObject *body, scene_body *one, const aoi_rule *rule)
{
    static const struct {
        const char *kind;
        int (*take)(buffer_list *, PyObject *, scene_body *, const aoi_rule *);
    } kinds[] = {{"star", take_star}, {"modal", take_modal}, {"full", take_full}};
    PyObject *kind = PyDict_Check(body) ? PyDict_GetItemString(body, "kind") : NULL;
    for (size_t i = 0; kind && i < sizeof kinds / sizeof kinds[0]; i++) {
        if (PyUnicode_Check(kind) && PyUnicode_CompareWithASCIIString(kind, kinds[i].kind) == 0) {
            return kinds[i].take(buffers, body, one, rule);
        }
    }
    buffers->failed = 1;
    PyErr_SetString(PyExc_TypeError, "a body is a dict of the kind \"star\", \"modal\" or \"full\"");
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

/* Bodies, contacts and loads as Python hands them over. */
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
    }
    for (size_t c = 0; c < scene->contact_count && status == AOI_OK && !buffers->failed; c++) {
        status = take_contact(buffers, item(contacts, (Py_ssize_t)c), &all->contact[c],
                              &all->law[c]);
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
        scene->memory = take_memory(buffers, 1, buffers->failed ? 0 : aoi_scene_size(scene));
    }
    return status;
}

/* Steps between looks for signals at most: of contacts without mass one may take a hundred times as long as those
 * before it, some 100 us. */
enum { MOST_STEPS = 256 };

/* Runs the steps in pieces without the GIL; between them signals are checked. */
static int run_in_pieces(scene_parts *all, double *record, size_t columns, size_t *done)
{
    const size_t steps = columns - 1;
    size_t piece = 1;
    *done = 0;
    signal_check_release(&all->signals);
    int status = aoi_scene_start(&all->scene, record, columns);
    signal_check_regain(&all->signals);
    while (status == AOI_OK && *done < steps) {
        const size_t first = *done + 1;
        const size_t last = steps - *done < piece ? steps : *done + piece;
        const clock_t began = clock();
        signal_check_release(&all->signals);
        status = aoi_scene_run(&all->scene, record, columns, first, last, done);
        signal_check_regain(&all->signals);
        piece = piece_after(piece, began);
        piece = piece < MOST_STEPS ? piece : MOST_STEPS;
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
    scene_parts all = {0};
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
                     ? run_in_pieces(&all, record, columns, &done)
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
