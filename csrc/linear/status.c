/* The version of the library, and texts of the status codes. */
#include "aoimpact.h"

const char *aoi_version(void) { return AOI_VERSION; }

const char *aoi_status_text(int status)
{
    static const char *const text[] = {
        [AOI_OK] = "no error",
        [AOI_ERROR_ARGUMENT] = "an argument is out of its range",
        [AOI_ERROR_NOT_FINITE] = "an infinity or NaN where a finite number is needed",
        [AOI_ERROR_NOT_POSITIVE] = "a mass, stiffness or pivot that must be positive is not",
        [AOI_ERROR_NO_CONVERGENCE] = "an iteration reached its limit",
        [AOI_ERROR_SOLVER] = "the linear solver failed",
        [AOI_ERROR_TOLERANCE] = "even the shortest step does not meet the tolerance",
        [AOI_ERROR_TOO_LONG] = "the run needs more rows than there is room for",
        [AOI_ERROR_PATCH] = "an indentation exceeds the limit of its contact law",
        [AOI_ERROR_LAW] = "a contact law gave NaN",
        [AOI_ERROR_LAW_JUMPS] = "with its compliance taken out, a contact law has no force at this indentation: its own force drops",
        [AOI_ERROR_STOPPED] = "the caller's pause ended the computation",
        [AOI_ERROR_FRICTION] = "friction needs a law without memory and adhesion, and in an adaptive run no damping and no residual compliance",
        [AOI_ERROR_SPRINGS] = "a contact with friction needs more springs than there is room for",
    };
    const int known = status >= 0 && (size_t)status < sizeof text / sizeof text[0];
    return known ? text[status] : "unknown status";
}
