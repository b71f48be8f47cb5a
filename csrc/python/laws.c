/* Python binding of the contact laws. */
#include "python/binding.h"
#include "law/law.h"

#include <math.h>

/* Converts the value returned by a law written in Python to a double. For an array, a string or a number out of
 * range it raises an error and returns NaN. */
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
    raise_made("law_result_error", Py_BuildValue("(Odd)", returned, indentation, rate));
    return (double)NAN;
}

/* The function aoi_user_law.call of a law written in Python; data: the tuple of its functions. It is called
 * without the GIL. After an exception, which stays set, the Python law is not called again, and NaN ends the run. */
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

/* Reads a law written by the user from the tuple (functions, depends_on_rate, pulls, object kept alive).
 * functions: a tuple of AOI_USER_FUNCTIONS items, which are callables, addresses of C functions, or None for a
 * function that is not given. */
static void take_user_law(call *of, PyObject *data, aoi_law *law)
{
    aoi_user_law user = {.call = NULL};
    PyObject *functions = NULL, *held;
    int depends, pulls;
    TAKE(of, data, VALUE('t', functions), VALUE('p', depends), VALUE('p', pulls), VALUE('O', held));
    for (int i = 0; i < AOI_USER_FUNCTIONS; i++) {
        PyObject *one = tuple_item(of, functions, (size_t)i, AOI_USER_FUNCTIONS);
        user.given[i] = one != Py_None;
        if (PyLong_Check(one)) {
            const uintptr_t address = (uintptr_t)PyLong_AsVoidPtr(one);
            user.function[i] = (double (*)(double, double))address;
        } else if (user.given[i]) {
            user.call = call_python;
        }
    }
    user.data = functions;
    if (of->status == AOI_OK) {
        of->status = aoi_law_create_user(law, &user, depends, pulls);
    }
}

static void take_table(call *of, PyObject *tuple, aoi_law *law)
{
    size_t points = ANY_LENGTH, columns = 4;
    const double *table;
    TAKE_SOME(of, tuple, 5, 6, MATRIX('d', table, points, columns));
    if (of->status == AOI_OK) {
        of->status = aoi_law_create_table(law, points, table);
    }
}

static void take_named_law(call *of, PyObject *name, PyObject *parameters, aoi_law *law)
{
    double parameter[AOI_LAW_PARAMETERS + 1];
    const size_t given = (size_t)PyTuple_Size(parameters), most = AOI_LAW_PARAMETERS + 1;
    /* one parameter too many is kept, for aoi_law_create to refuse */
    const size_t count = given < most ? given : most;
    for (size_t i = 0; i < count; i++) {
        parameter[i] = PyFloat_AsDouble(PyTuple_GetItem(parameters, (Py_ssize_t)i));
    }
    const char *text = PyErr_Occurred() ? NULL : PyUnicode_AsUTF8AndSize(name, NULL);
    call_fail(of, text ? aoi_law_create(law, text, count, parameter) : CALL_RAISED);
}

void take_law(call *of, PyObject *tuple, aoi_law *law)
{
    PyObject *name = NULL, *parameters = NULL, *data = NULL;
    double compliance = 0.0, limit = 0.0, *note = NULL;
    size_t entries = AOI_LAW_NOTE;
    TAKE(of, tuple, VALUE('O', name), VALUE('t', parameters), VALUE('x', compliance), VALUE('x', limit),
         ARRAY('D', note, entries), VALUE('O', data));
    if (of->status != AOI_OK) {
        return;
    }
    if (PyUnicode_Check(name) && PyUnicode_CompareWithASCIIString(name, "user") == 0) {
        take_user_law(of, data, law);
    } else if (PyUnicode_Check(name) && PyUnicode_CompareWithASCIIString(name, "table") == 0) {
        take_table(of, tuple, law);
    } else {
        take_named_law(of, name, parameters, law);
    }
    if (of->status == AOI_OK) {
        law->compliance = compliance;
        law->limit = limit;
        law->note = note;
        note[0] = note[1] = (double)NAN;
        of->status = aoi_law_check(law);
    }
}

/* Reads friction from the tuple (mu, ratio, precision, compliance of shape (3, 3) or None). */
static void take_friction(call *of, PyObject *tuple, aoi_contact *contact, aoi_friction *friction)
{
    double mu = 0.0, ratio = 0.0, precision = 0.0;
    size_t entries = 9;
    TAKE(of, tuple, VALUE('x', mu), VALUE('x', ratio), VALUE('x', precision), ARRAY('o', contact->compliance, entries));
    if (of->status == AOI_OK) {
        of->status = aoi_friction_create(friction, contact->law, mu, ratio, precision);
        contact->friction = friction;
    }
}

void take_contact(call *of, PyObject *tuple, aoi_contact *contact, aoi_law *law, aoi_friction *friction)
{
    PyObject *described = NULL, *rubs = Py_None;
    const size_t items = PyTuple_Check(tuple) && PyTuple_Size(tuple) == 7 ? 7 : 6;
    contact->law = law;
    TAKE_SOME(of, tuple, 0, items, VALUE('n', contact->body[0]), VALUE('n', contact->port[0]),
              VALUE('n', contact->body[1]), VALUE('n', contact->port[1]), VALUE('x', contact->gap),
              VALUE('O', described));
    take_law(of, described, law);
    if (items == 7) {
        TAKE_SOME(of, tuple, 6, items, VALUE('O', rubs));
    }
    if (rubs != Py_None) {
        take_friction(of, rubs, contact, friction);
    }
}

void raise_of_laws(call *of, const char *what, double time, const aoi_law *law, size_t count, size_t contact)
{
    double indentation = (double)NAN, rate = (double)NAN;
    int why = of->status;
    if (PyErr_Occurred() || of->status <= AOI_OK) {
        return;
    }
    for (size_t i = 0; i < count && isnan(indentation) && law[i].note; i++) {
        indentation = law[i].note[0];
        rate = law[i].note[1];
        /* The NaN of the law has caused the failure of the run, for example a missed tolerance: the reason in the
         * law's note is reported. */
        if (!isnan(indentation) && of->status != AOI_ERROR_PATCH && of->status != AOI_ERROR_ARGUMENT) {
            why = (int)law[i].note[2];
        }
    }
    raise_at(why, what, time, indentation, rate, of->status == AOI_ERROR_PATCH ? (Py_ssize_t)contact : -1);
    of->status = CALL_RAISED;
}

/* Checks for signals if i is a multiple of 4096. Returns 0 if a signal has raised an error. */
static int no_signal(size_t i) { return i % 4096 != 0 || PyErr_CheckSignals() == 0; }

static PyObject *finish_law(call *of, const aoi_law *law)
{
    if (of->status != AOI_ERROR_ARGUMENT) {
        raise_of_laws(of, "contact law", -1.0, law, 1, 0);
    }
    return finish(of, "contact law", "");
}

/* Writes force, stiffness and damping of a law to the arrays. args: (law, indentation, rate, force, stiffness,
 * damping, along). along = 1: the indentations are successive states of one contact, whose memory is updated; 0:
 * each is that of a first touch. */
PyObject *law_force(PyObject *args)
{
    call of = {.status = AOI_OK};
    PyObject *described = NULL;
    const double *indentation, *rate;
    double *force, *stiffness, *damping, memory[AOI_LAW_MEMORY] = {0.0};
    size_t n = ANY_LENGTH;
    int along;
    aoi_law law = {.note = NULL};
    TAKE(&of, args, VALUE('t', described), ARRAY('d', indentation, n), ARRAY('d', rate, n), ARRAY('D', force, n),
         ARRAY('D', stiffness, n), ARRAY('D', damping, n), VALUE('p', along));
    take_law(&of, described, &law);
    for (size_t i = 0; of.status == AOI_OK && i < n && no_signal(i); i++) {
        aoi_law_value value;
        aoi_law_push(&law, memory, indentation[i], rate[i], &value);
        force[i] = value.force;
        stiffness[i] = value.stiffness;
        damping[i] = value.damping;
        if (isnan(value.force)) {
            of.status = AOI_ERROR_LAW;
        } else if (!aoi_law_stands(&law, memory, indentation[i], rate[i])) {
            of.status = AOI_ERROR_PATCH;
        } else if (along) {
            aoi_law_remember(&law, indentation[i], rate[i], memory);
        }
    }
    return finish_law(&of, &law);
}

/* Writes the potential of a law, J, to the array energy. args: (law, indentation, energy). */
PyObject *law_potential(PyObject *args)
{
    call of = {.status = AOI_OK};
    PyObject *described = NULL;
    const double *indentation, untouched[AOI_LAW_MEMORY] = {0.0};
    double *energy;
    size_t n = ANY_LENGTH;
    aoi_law law = {.note = NULL};
    TAKE(&of, args, VALUE('t', described), ARRAY('d', indentation, n), ARRAY('D', energy, n));
    take_law(&of, described, &law);
    for (size_t i = 0; of.status == AOI_OK && i < n && no_signal(i); i++) {
        energy[i] = aoi_law_potential(&law, untouched, indentation[i]);
        of.status = isnan(energy[i]) ? AOI_ERROR_LAW : AOI_OK;
    }
    return finish_law(&of, &law);
}
