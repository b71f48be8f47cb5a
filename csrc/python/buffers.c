/* Buffers in, errors out: what every function of the binding uses. */
#include "python/binding.h"
#include "aoimpact.h"

#include <math.h>
#include <stdlib.h>

void buffers_release(buffer_list *buffers)
{
    buffer_block *block = &buffers->block;
    while (block) {
        buffer_block *next = block->next;
        for (int i = 0; i < block->count; i++) {
            PyBuffer_Release(&block->view[i]);
        }
        if (block != &buffers->block) {
            free(block);
        }
        block = next;
    }
    buffers->block.count = 0;
    buffers->block.next = NULL;
}

/* A block with room for one more: the first, or the most recent overflow block, inserted after the first. */
static buffer_block *with_room(buffer_list *buffers)
{
    buffer_block *block = &buffers->block;
    if (block->count == MOST_BUFFERS && block->next) {
        block = block->next;
    }
    if (block->count == MOST_BUFFERS) {
        block = malloc(sizeof *block);
        if (!block) {
            PyErr_NoMemory();
            return NULL;
        }
        block->count = 0;
        block->next = buffers->block.next;
        buffers->block.next = block;
    }
    return block;
}

void *buffers_take(buffer_list *buffers, PyObject *object, const char *name, char type, int writable,
                size_t *count)
{
    const Py_ssize_t size = type == 'd' ? (Py_ssize_t)sizeof(double) : 4;
    const int flags = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (writable ? PyBUF_WRITABLE : 0);
    if (buffers->failed) {
        return NULL;
    }
    buffers->failed = 1;
    /* An error may be there from the conversion of a number before. */
    buffer_block *block = PyErr_Occurred() ? NULL : with_room(buffers);
    if (!block || PyObject_GetBuffer(object, &block->view[block->count], flags) != 0) {
        return NULL;
    }
    Py_buffer *view = &block->view[block->count++];
    const char code = view->format ? view->format[0] : 'B';
    if (view->itemsize != size || (type == 'i' ? code != 'i' && code != 'l' : code != type)) {
        PyErr_Format(PyExc_TypeError, "%s must be a C-contiguous buffer of %s, not of format '%s'",
                     name, type == 'd' ? "float64" : type == 'f' ? "float32" : "int32",
                     view->format ? view->format : "B");
        return NULL;
    }
    buffers->failed = 0;
    const size_t length = (size_t)(view->len / size);
    if (*count == (size_t)-1) {
        *count = length;
    } else if (*count != length) {
        buffers->failed = 1;
        PyErr_Format(PyExc_ValueError, "%s must hold %zu values, not %zu", name, *count, length);
        return NULL;
    }
    return view->buf;
}

const double *doubles(buffer_list *buffers, PyObject *object, const char *name, size_t *count)
{
    return buffers_take(buffers, object, name, 'd', 0, count);
}

const double *doubles_or_none(buffer_list *buffers, PyObject *object, const char *name, size_t *count)
{
    return object == Py_None ? NULL : doubles(buffers, object, name, count);
}

double *doubles_out(buffer_list *buffers, PyObject *object, const char *name, size_t *count)
{
    return buffers_take(buffers, object, name, 'd', 1, count);
}

const int32_t *integers(buffer_list *buffers, PyObject *object, const char *name, size_t *count)
{
    return buffers_take(buffers, object, name, 'i', 0, count);
}

PyObject *raise_made(const char *maker, PyObject *arguments)
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
    return NULL;
}

PyObject *raise_at(int status, const char *what, double time, double indentation, double rate,
                   Py_ssize_t contact)
{
    return raise_made("core_error",
                      Py_BuildValue("(isdddn)", status, what, time, indentation, rate, contact));
}

PyObject *raise_status(int status, const char *what, double time)
{
    return raise_at(status, what, time, (double)NAN, (double)NAN, -1);
}

PyObject *finish(buffer_list *buffers, int status, const char *what)
{
    buffers_release(buffers);
    if (buffers->failed || PyErr_Occurred()) { /* a signal, or what was called back */
        return NULL;
    }
    if (status != AOI_OK) {
        return raise_status(status, what, -1.0);
    }
    Py_RETURN_NONE;
}

void need_tuple(buffer_list *buffers, PyObject *tuple, Py_ssize_t size)
{
    if (!buffers->failed && (!PyTuple_Check(tuple) || PyTuple_Size(tuple) != size)) {
        buffers->failed = 1;
        PyErr_Format(PyExc_TypeError, "a tuple of %zd buffers is needed here", size);
    }
}

int is_kind(PyObject *tuple, const char *kind)
{
    PyObject *first = PyTuple_GetItem(tuple, 0);
    return PyUnicode_Check(first) && PyUnicode_CompareWithASCIIString(first, kind) == 0;
}
