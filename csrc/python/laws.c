/* The contact laws, for Python. */
#include "python/binding.h"
#include "law/law.h"

#include <math.h>

/* Numbers of a tuple; -1, with an error set, where it is none or they are too many. */
static Py_ssize_t take_parameters(PyObject *tuple, double *parameter)
{
    const Py_ssize_t count = PyTuple_Check(tuple) ? PyTuple_Size(tuple) : AOI_LAW_PARAMETERS + 1;
    if (count > AOI_LAW_PARAMETERS) {
        PyErr_SetString(PyExc_TypeError, "a law's parameters are a tuple of a few numbers");
        return -1;
    }
    for (Py_ssize_t i = 0; i < count; i++) {
        parameter[i] = PyFloat_AsDouble(PyTuple_GetItem(tuple, i));
    }
    return PyErr_Occurred() ? -1 : count;
}

/* The value returned by a function of a law written in Python: a number that a double holds, not an array or a text. */
static double number_of(PyObject *returned, double indentation, double rate)
{
    if (PyFloat_Check(returned) || (PyNumber_Check(returned) && !PySequence_Check(returned) &&
                                    !PyComplex_Check(returned))) {
        const double number = PyFloat_AsDouble(returned);
        const PyObject *raised = PyErr_Occurred();
        if (!raised || !(PyErr_ExceptionMatches(PyExc_OverflowError) || PyErr_ExceptionMatches(PyExc_TypeError))) {
            return number;
        }
        PyErr_Clear();
    }
    (void)raise_made("law_result_error", Py_BuildValue("(Odd)", returned, indentation, rate));
    return (double)NAN;
}

/* aoi_user_law.call of a law in Python; data: the tuple of its functions. The run holds no GIL. What
 * the law raises stays set, and the law is not called again: NaN ends the run. */
static double call_python(void *data, int which, double indentation, double rate)
{
    const PyGILState_STATE state = PyGILState_Ensure();
    double answer = (double)NAN;
    if (!PyErr_Occurred()) {
        PyObject *result = PyObject_CallFunction(PyTuple_GetItem(data, which), "dd", indentation,
                                                 rate);
        if (result) {
            answer = number_of(result, indentation, rate);
            Py_DECREF(result);
        }
    }
    PyGILState_Release(state);
    return answer;
}

/* data: (functions, depends_on_rate, pulls, what to hold on to), functions a tuple of AOI_USER_FUNCTIONS callables or
 * addresses, None where there is none. */
static int take_user_law(buffer_list *buffers, PyObject *data, aoi_law *law)
{
    aoi_user_law user = {.call = NULL};
    need_tuple(buffers, data, 4);
    PyObject *functions = buffers->failed ? NULL : PyTuple_GetItem(data, 0);
    need_tuple(buffers, functions, AOI_USER_FUNCTIONS);
    if (buffers->failed) {
        return AOI_OK;
    }
    user.data = functions;
    for (int i = 0; i < AOI_USER_FUNCTIONS; i++) {
        PyObject *one = PyTuple_GetItem(functions, i);
        user.given[i] = one != Py_None;
        if (PyLong_Check(one)) {
            const uintptr_t address = (uintptr_t)PyLong_AsVoidPtr(one);
            user.function[i] = (double (*)(double, double))address;
        } else if (user.given[i]) {
            user.call = call_python;
        }
    }
    const int depends = PyObject_IsTrue(PyTuple_GetItem(data, 1));
    const int pulls = PyObject_IsTrue(PyTuple_GetItem(data, 2));
    return aoi_law_create_user(law, &user, depends != 0, pulls != 0);
}

static int take_named_law(buffer_list *buffers, PyObject *name, PyObject *parameters, aoi_law *law)
{
    double parameter[AOI_LAW_PARAMETERS];
    const Py_ssize_t count = take_parameters(parameters, parameter);
    const char *text = count < 0 ? NULL : PyUnicode_AsUTF8AndSize(name, NULL);
    if (!text) {
        buffers->failed = 1;
        return AOI_OK;
    }
    return aoi_law_create(law, text, (size_t)count, parameter);
}

int take_law(buffer_list *buffers, PyObject *tuple, aoi_law *law)
{
    size_t entries = AOI_LAW_NOTE, values = (size_t)-1;
    int status;
    need_tuple(buffers, tuple, 6);
    if (buffers->failed) {
        return AOI_OK;
    }
    PyObject *name = PyTuple_GetItem(tuple, 0), *data = PyTuple_GetItem(tuple, 5);
    const double compliance = PyFloat_AsDouble(PyTuple_GetItem(tuple, 2));
    const double limit = PyFloat_AsDouble(PyTuple_GetItem(tuple, 3));
    double *note = doubles_out(buffers, PyTuple_GetItem(tuple, 4), "note", &entries);
    if (is_kind(tuple, "user")) {
        status = take_user_law(buffers, data, law);
    } else if (is_kind(tuple, "table")) {
        const double *table = doubles(buffers, data, "table", &values);
        status = buffers->failed ? AOI_OK : aoi_law_create_table(law, values / 4, table);
    } else {
        status = buffers->failed
                     ? AOI_OK
                     : take_named_law(buffers, name, PyTuple_GetItem(tuple, 1), law);
    }
    law->compliance = compliance;
    law->limit = limit;
    law->note = note;
    if (note) {
        note[0] = note[1] = (double)NAN;
    }
    if (buffers->failed || status != AOI_OK) {
        return status;
    }
    return aoi_law_check(law);
}

int take_contact(buffer_list *buffers, PyObject *tuple, aoi_contact *contact, aoi_law *law)
{
    need_tuple(buffers, tuple, 6);
    if (buffers->failed) {
        return AOI_OK;
    }
    for (Py_ssize_t i = 0; i < 2; i++) {
        contact->body[i] = PyLong_AsSize_t(PyTuple_GetItem(tuple, 2 * i));
        contact->port[i] = PyLong_AsSize_t(PyTuple_GetItem(tuple, 2 * i + 1));
    }
    contact->gap = PyFloat_AsDouble(PyTuple_GetItem(tuple, 4));
    contact->law = law;
    if (PyErr_Occurred()) {
        buffers->failed = 1;
        return AOI_OK;
    }
    return take_law(buffers, PyTuple_GetItem(tuple, 5), law);
}

PyObject *raise_of_laws(int status, const char *what, double time, const aoi_law *law, size_t count,
                        Py_ssize_t contact)
{
    double indentation = (double)NAN, rate = (double)NAN;
    int why = AOI_ERROR_LAW;
    if (PyErr_Occurred()) {
        return NULL; /* what a law of the caller's raised, as it is */
    }
    for (size_t i = 0; i < count && isnan(indentation) && law[i].note; i++) {
        indentation = law[i].note[0];
        rate = law[i].note[1];
        why = isnan(indentation) ? why : (int)law[i].note[2];
    }
    /* A NaN that the run only met as its own trouble. */
    const int of_a_law = !isnan(indentation) && status != AOI_ERROR_PATCH &&
                         status != AOI_ERROR_ARGUMENT;
    return raise_at(of_a_law ? why : status, what, time, indentation, rate,
                    status == AOI_ERROR_PATCH ? contact : -1);
}

/* Checks signals in every 4096th call; 0 where one has raised. */
static int no_signal(size_t i) { return i % 4096 != 0 || PyErr_CheckSignals() == 0; }

/* finish() for a status that may be the law's. */
static PyObject *finish_law(buffer_list *buffers, int status, const aoi_law *law)
{
    if (!buffers->failed && status != AOI_OK && status != AOI_ERROR_ARGUMENT) {
        (void)raise_of_laws(status, "contact law", -1.0, law, 1, -1);
        buffers->failed = 1;
    }
    return finish(buffers, status, "contact law");
}

PyObject *law_force(PyObject *self, PyObject *args)
{
    PyObject *law_in, *indentation_in, *rate_in, *force_out, *stiffness_out, *damping_out;
    buffer_list buffers = {.failed = 0};
    size_t n = (size_t)-1;
    double memory[AOI_LAW_MEMORY] = {0.0};
    int along; /* the indentations follow each other, and the law remembers them */
    aoi_law law;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!OOOOOp", &PyTuple_Type, &law_in, &indentation_in, &rate_in,
                          &force_out, &stiffness_out, &damping_out, &along)) {
        return NULL;
    }
    int status = take_law(&buffers, law_in, &law);
    const double *indentation = doubles(&buffers, indentation_in, "indentation", &n);
    const double *rate = doubles(&buffers, rate_in, "rate", &n);
    double *force = doubles_out(&buffers, force_out, "force", &n);
    double *stiffness = doubles_out(&buffers, stiffness_out, "stiffness", &n);
    double *damping = doubles_out(&buffers, damping_out, "damping", &n);
    for (size_t i = 0; !buffers.failed && status == AOI_OK && i < n && no_signal(i); i++) {
        aoi_law_value value;
        aoi_law_push(&law, memory, indentation[i], rate[i], &value);
        force[i] = value.force;
        stiffness[i] = value.stiffness;
        damping[i] = value.damping;
        if (isnan(value.force)) {
            status = AOI_ERROR_LAW;
        } else if (!aoi_law_stands(&law, memory, indentation[i], rate[i])) {
            status = AOI_ERROR_PATCH;
        } else if (along) {
            aoi_law_remember(&law, indentation[i], rate[i], memory);
        }
    }
    return finish_law(&buffers, status, &law);
}

PyObject *law_potential(PyObject *self, PyObject *args)
{
    PyObject *law_in, *indentation_in, *energy_out;
    buffer_list buffers = {.failed = 0};
    size_t n = (size_t)-1;
    const double untouched[AOI_LAW_MEMORY] = {0.0};
    aoi_law law;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!OO", &PyTuple_Type, &law_in, &indentation_in, &energy_out)) {
        return NULL;
    }
    int status = take_law(&buffers, law_in, &law);
    const double *indentation = doubles(&buffers, indentation_in, "indentation", &n);
    double *energy = doubles_out(&buffers, energy_out, "energy", &n);
    for (size_t i = 0; !buffers.failed && status == AOI_OK && i < n && no_signal(i); i++) {
        energy[i] = aoi_law_potential(&law, untouched, indentation[i]);
        status = isnan(energy[i]) ? AOI_ERROR_LAW : AOI_OK;
    }
    return finish_law(&buffers, status, &law);
}
