/* Contact laws of every kind, with and without a patch, and the contact equation. */
#include "fuzz.h"
#include "law/equation.h"
#include "law/law.h"

static void look_at_laws(input *in, const aoi_law *law, double *memory)
{
    const double d = take_byte(in) % 16 ? take_signed(in) : take_any(in);
    const double rate = take_byte(in) % 16 ? take_signed(in) : take_any(in);
    const int tame = isfinite(d) && isfinite(rate) && fabs(d) < 1e30 && fabs(rate) < 1e30 &&
                     in->decades <= 12.0 && !in->spoiled;
    aoi_law_value value, again;
    double low, high;
    aoi_law_push(law, memory, d, rate, &value);
    const double alone = aoi_law_push_only(law, memory, d, rate);
    const int piece = aoi_law_piece(law, memory, d, take_byte(in) & 1, &low, &high);
    REQUIRE(isnan(low) || isnan(high) || isnan(d) || low <= high || law->compliance > 0.0);
    if (piece != AOI_NO_PIECE) {
        aoi_law_force(law, memory, piece, d, rate, &again);
    }
    REQUIRE(law->pulls || !(value.force < 0.0));
    REQUIRE(isnan(alone) == isnan(value.force) || !tame);
    if (tame && !may_fail(law)) {
        REQUIRE(isfinite(value.force) && isfinite(value.stiffness) && isfinite(value.damping));
        REQUIRE(aoi_law_potential(law, memory, d) >= 0.0);
    }
    (void)aoi_law_stands(law, memory, d, rate);
    (void)aoi_law_potential(law, memory, d);
    if ((take_byte(in) & 1) && fabs(d) < 1e100 && fabs(rate) < 1e100) {
        aoi_law_remember(law, d, rate, memory);
        REQUIRE(!tame || may_fail(law) || (isfinite(memory[0]) && isfinite(memory[1])));
    }
}

static void solve(input *in, const aoi_law *law, const double *memory)
{
    const int odd = take_byte(in) % 16 == 0;
    taker *some = odd ? take_any : take_signed;
    aoi_contact_equation equation = {some(in), 0.0, some(in), 0.0, 0.0};
    equation.compliance = odd ? take_any(in) : take_positive(in);
    equation.rate_compliance = odd ? take_any(in) : take_positive(in);
    equation.guess = take_byte(in) % 4 ? take_signed(in) : take_any(in);
    double force = NAN, indentation = NAN;
    if (aoi_contact_solve(law, memory, &equation, &force, &indentation) != AOI_OK) {
        return;
    }
    const double rest = aoi_law_rest(law, memory), free_end = equation.indentation_free;
    REQUIRE(isfinite(force) && isfinite(indentation));
    REQUIRE(law->pulls || force >= 0.0);
    REQUIRE(law->pulls || indentation <= fmax(free_end, rest));
    REQUIRE(force == 0.0 || indentation >= rest);
    if (law->pulls || law->user.call || law->compliance != 0.0 || in->decades > 12.0 || in->spoiled || odd) {
        return;
    }
    const double left = indentation + equation.compliance * force - free_end;
    const double rate = equation.rate_free - equation.rate_compliance * force;
    aoi_law_value value, beyond;
    aoi_law_push(law, memory, indentation, rate, &value);
    aoi_law_push(law, memory, nextafter(indentation, HUGE_VAL), rate, &beyond);
    /* To rounding, of what the law's slopes make of it: a table may have knots next to each other. */
    const double secant = value.force / (indentation - rest); /* of all digits that a deep dent leaves */
    const double slopes = 1.0 + equation.rate_compliance * value.damping +
                          equation.compliance * fmax(fmax(value.stiffness, beyond.stiffness), secant);
    const double rates = equation.compliance * value.damping *
                         (fabs(equation.rate_free) + equation.rate_compliance * force);
    /* memory[0]: the deepest indentation, with its rounding */
    const double places = 1e-12 * (fabs(free_end) + fabs(indentation) + equation.compliance * force) +
                          4.0 * DBL_EPSILON * memory[0];
    REQUIRE(force == 0.0 || fabs(left) <= places * slopes + 1e-12 * rates + DBL_MIN);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = open_input(data, size);
    double *memory = take_room(&in, AOI_LAW_MEMORY);
    int status;
    const aoi_law law = take_law(&in, &status);
    for (int i = 0; status == AOI_OK && i < 4; i++) {
        look_at_laws(&in, &law, memory);
        solve(&in, &law, memory);
    }
    close_input(&in);
    return 0;
}
