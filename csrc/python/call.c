/* Conversion of arguments, results and errors, for all functions of the binding. */
#include "python/binding.h"

#include "linear/work.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

void call_fail(call *of, int status) { of->status = of->status == AOI_OK ? status : of->status; }

static void raise_in(call *of, PyObject *type, const char *text, const char *name, size_t number)
{
    PyErr_Format(type, text, name, number);
    call_fail(of, CALL_RAISED);
}

void *call_room(call *of, size_t count, size_t size)
{
    void *room = of->status == AOI_OK ? calloc(count + 1, size) : NULL;
    call_fail(of, room ? AOI_OK : CALL_NO_MEMORY);
    return room;
}

/* ---------------------------------------------------------------------------------- buffers */

void call_release(call *of)
{
    buffer_block *block = &of->block;
    while (block) {
        buffer_block *next = block->next;
        for (int i = 0; i < block->count; i++) {
            PyBuffer_Release(&block->view[i]);
        }
        if (block != &of->block) {
            free(block);
        }
        block = next;
    }
    of->block.count = 0;
    of->block.next = NULL;
}

/* Returns a block with room for one more buffer: the first block, or else the newest of the others, which is
 * inserted behind the first. NULL with an error set if there is no memory. */
static buffer_block *with_room(call *of)
{
    buffer_block *block = of->block.count == MOST_BUFFERS && of->block.next ? of->block.next : &of->block;
    if (block->count == MOST_BUFFERS) {
        block = calloc(1, sizeof *block);
        if (!block) {
            PyErr_NoMemory();
            return NULL;
        }
        block->next = of->block.next;
        of->block.next = block;
    }
    return block;
}

/* Checks the length of an array or, if *count is ANY_LENGTH, sets *count from it. */
static void fit(call *of, const argument *row, size_t length)
{
    const size_t each = row->each ? *row->each : 1;
    if (*row->count == ANY_LENGTH && each > 0 && each != ANY_LENGTH && length >= row->more &&
        (length - row->more) % each == 0) {
        *row->count = (length - row->more) / each;
    }
    const size_t needed = aoi_times(*row->count, each);
    if (*row->count == ANY_LENGTH || needed + row->more != length) {
        raise_in(of, PyExc_ValueError, "%s must hold %zu values, or a multiple", row->name,
                 (*row->count == ANY_LENGTH ? each : needed) + row->more);
    }
}

/* Takes a buffer of float64, float32 or int32 and stores the address of its data. */
static void take_buffer(call *of, PyObject *object, const argument *row)
{
    static const char *const type[] = {"dDo", "fF", "iI"}, *const wanted[] = {"float64", "float32", "int32"};
    const size_t which = strchr(type[0], row->kind) ? 0 : strchr(type[1], row->kind) ? 1 : 2;
    const Py_ssize_t size = which == 0 ? (Py_ssize_t)sizeof(double) : 4;
    const int flags = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (strchr("DFI", row->kind) ? PyBUF_WRITABLE : 0);
    void *found = NULL;
    if (row->kind == 'o' && object == Py_None) {
        memcpy(row->to, &found, sizeof found);
        return;
    }
    buffer_block *block = with_room(of);
    if (!block || PyObject_GetBuffer(object, &block->view[block->count], flags) != 0) {
        call_fail(of, CALL_RAISED);
        return;
    }
    const Py_buffer *view = &block->view[block->count++];
    const char code = view->format ? view->format[0] : 'B';
    if (view->itemsize != size || !(which == 2 ? code == 'i' || code == 'l' : code == type[which][0])) {
        PyErr_Format(PyExc_TypeError, "%s must be a C-contiguous buffer of %s, not of format '%s'", row->name,
                     wanted[which], view->format ? view->format : "B");
        call_fail(of, CALL_RAISED);
        return;
    }
    memcpy(row->to, &view->buf, sizeof view->buf);
    fit(of, row, (size_t)(view->len / size));
}

/* -------------------------------------------------------------------------------- arguments */

static void take_one(call *of, PyObject *object, const argument *row)
{
    if (row->kind == 'x') {
        *(double *)row->to = PyFloat_AsDouble(object);
    } else if (row->kind == 'n') {
        /* a negative number is converted to one that is too large, which is refused */
        *(size_t *)row->to = (size_t)PyLong_AsSsize_t(object);
    } else if (row->kind == 'p') {
        *(int *)row->to = PyObject_IsTrue(object) != 0;
    } else if (row->kind == 'O' || row->kind == 't') {
        *(PyObject **)row->to = object;
        if (row->kind == 't' && !PyTuple_Check(object)) {
            raise_in(of, PyExc_TypeError, "%s must be a tuple", row->name, 0);
        }
    } else {
        take_buffer(of, object, row);
    }
    if (PyErr_Occurred()) {
        call_fail(of, CALL_RAISED);
    }
}

PyObject *tuple_item(call *of, PyObject *tuple, size_t i, size_t size)
{
    if (of->status == AOI_OK && (!PyTuple_Check(tuple) || (size_t)PyTuple_Size(tuple) != size)) {
        raise_in(of, PyExc_TypeError, "%s of %zu is needed here", "a tuple", size);
    }
    return of->status == AOI_OK ? PyTuple_GetItem(tuple, (Py_ssize_t)i) : Py_None;
}

void call_take(call *of, PyObject *tuple, size_t first, size_t size, size_t count, const argument *table)
{
    uint32_t done = 0;
    /* the second pass takes matrices whose number of columns is set by another array */
    for (int last = 0; last < 2; last++) {
        for (size_t i = 0; i < count && of->status == AOI_OK; i++) {
            const int waits = !last && table[i].each && *table[i].each == ANY_LENGTH;
            if (!waits && !(done >> i & 1)) {
                PyObject *object = tuple_item(of, tuple, first + i, size);
                done |= (uint32_t)1 << i;
                if (of->status == AOI_OK) {
                    take_one(of, object, &table[i]);
                }
            }
        }
    }
}

/* ----------------------------------------------------------------------------------- errors */

void raise_made(const char *maker, PyObject *arguments)
{
    PyObject *module = arguments ? PyImport_ImportModule("aoimpact.base.errors") : NULL;
    PyObject *make = module ? PyObject_GetAttrString(module, maker) : NULL;
    PyObject *error = make ? PyObject_CallObject(make, arguments) : NULL;
    if (error) {
        PyErr_SetObject((PyObject *)Py_TYPE(error), error);
    }
    Py_XDECREF(error);
    Py_XDECREF(make);
    Py_XDECREF(module);
    Py_XDECREF(arguments);
}

void raise_at(int status, const char *what, double time, double indentation, double rate, Py_ssize_t contact)
{
    raise_made("core_error", Py_BuildValue("(isdddn)", status, what, time, indentation, rate, contact));
}

PyObject *finish(call *of, const char *what, const char *format, ...)
{
    call_release(of);
    if (of->status == CALL_RAISED || PyErr_Occurred()) { /* an error set by a signal handler or a callback */
        return NULL;
    }
    if (of->status == CALL_NO_MEMORY) {
        return PyErr_NoMemory();
    }
    if (of->status != AOI_OK) {
        raise_at(of->status, what, -1.0, (double)NAN, (double)NAN, -1);
        return NULL;
    }
    va_list values;
    va_start(values, format);
    PyObject *result = Py_VaBuildValue(format, values);
    va_end(values);
    return result;
}
