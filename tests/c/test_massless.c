/* Adaptive runs of places without mass, where all forces balance at any time: closed forms over the whole range of
 * tolerances. */
#include "plant.h"

/* A place without mass on a spring on a body at rest; all ports are there. */
static part *add_place(plant *p, double mass, size_t ports, double compliance)
{
    part *made = add_rigid(p, mass, 0.0);
    made->ports = ports;
    made->massless = 1;
    for (size_t q = 0; q < ports; q++) {
        made->shape[q] = 1.0;
        made->push[q] = 1.0 / mass;
    }
    for (size_t i = 0; i < ports * ports; i++) {
        made->residual[i] = compliance;
    }
    return made;
}

/* A massless platform between two ports passes an impact on at once: it is at c F(t), and touches a wall when
 * that has grown to the gap. */
static void what_a_force_bends_touches_elsewhere(void)
{
    const double k = 2.5e6, c = 3e-7, mass = 0.4, v = 2.0, series = k / (1.0 + k * c), rtol = 1e-9;
    const double w = sqrt(series / mass), gap = 0.6 * c * series * v / w;
    const aoi_law law = linear(k);
    plant p = {.bodies = 0};
    add_rigid(&p, mass, v);
    add_place(&p, 1e12, 2, c);
    add_wall(&p);
    join(&p, 0, 0, 1, 0, 0.0, &law);
    join(&p, 1, 1, 2, 0, gap, &law);
    must_go(&p, rtol, 0.5 * PI / w);
    CHECK(near(moment_of(&p, 1, AOI_TRACK_BEGINS), asin(0.6) / w, 10.0 * rtol), "touch at %.12g, not %.12g",
          moment_of(&p, 1, AOI_TRACK_BEGINS), asin(0.6) / w);
    /* From then on the platform's springs, the law's and the wall's share the force. */
    CHECK(open_sampler(&p) == AOI_OK, "sampled");
    for (int i = 0; i <= 50; i++) {
        double record[64];
        aoi_sampler_column(p.sampler, 0.01 * i * PI / w, 0, record, 1);
        const double u = c * (record[0] - record[AOI_CONTACT_ROWS]); /* of the platform */
        CHECK(fabs(record[AOI_CONTACT_ROWS + 1] - (u - gap)) < 1e-8 * gap, "the second contact: %g, not %g",
              record[AOI_CONTACT_ROWS + 1], u - gap);
    }
    release(&p);
}

/* A massless place on a spring, and two bodies that nothing stops, which push it, the second from a gap on. */
static plant pushed_by_two(double V, double soft, double gap, const aoi_law *first, const aoi_law *second)
{
    plant p = {.bodies = 0};
    add_place(&p, 1e12, 1, soft); /* as good as fixed */
    add_rigid(&p, 1e12, V);
    add_rigid(&p, 1e12, V);
    join(&p, 1, 0, 0, 0, 0.0, first);
    join(&p, 2, 0, 0, 0, gap, second);
    return p;
}

/* The largest differences between the contacts' forces and those wanted, at the times before touch and after, in
 * shares of the largest. */
typedef void forces_at(const void *data, double t, double *force);

static double off_by(plant *p, double end, double touch, double near_touch, forces_at *wanted, const void *data)
{
    double worst[2] = {0.0, 0.0}, peak[2] = {0.0, 0.0}, force[2];
    CHECK(open_sampler(p) == AOI_OK, "sampled");
    for (int i = 0; i <= 500; i++) {
        const double t = end * i / 500.0;
        wanted(data, t, force);
        for (int j = 0; j < 2 && fabs(t - touch) > near_touch; j++) {
            worst[j] = fmax(worst[j], fabs(force_at(p, j, t) - force[j]));
            peak[j] = fmax(peak[j], force[j]);
        }
    }
    return fmax(worst[0] / peak[0], worst[1] / peak[1]);
}

typedef struct pushes {
    double V, n, k[2], c[2], soft, over, gap, touch; /* over: so far the first presses from the start */
} pushes;

/* k1 (over + V t - u)^n + k2 (V t - gap - u)^n = u / soft, each only where it presses. */
static void forces_of_springs(const void *data, double t, double *force)
{
    const pushes *of = data;
    double low = 0.0, high = of->over + of->V * t;
    for (int i = 0; i < 100; i++) {
        const double u = 0.5 * (low + high), past = of->V * t - of->gap - u;
        force[0] = of->k[0] * pow(of->over + of->V * t - u, of->n);
        force[1] = past > 0.0 ? of->k[1] * pow(past, of->n) : 0.0;
        *(force[0] + force[1] > u / of->soft ? &low : &high) = u;
    }
}

/* Laws without rate: the place is where all forces on it balance, whatever was before. */
static void a_second_spring_takes_its_share_at_once(void)
{
    const double end = 1e-4, exponents[] = {1.0, 1.5, 2.5};
    for (int e = 0; e < 6; e++) {
        pushes of = {.V = 1.0, .n = exponents[e % 3], .soft = 1e-8, .over = e < 3 ? 0.0 : 3e-5};
        of.gap = e < 3 ? 2e-5 : 1e-6;
        of.k[0] = pow(10.0, 4.0 + 4.0 * of.n);
        of.k[1] = 1.5 * of.k[0];
        const aoi_law laws[] = {law_named("power", 2, of.k[0], of.n, 0.0), law_named("power", 2, of.k[1], of.n, 0.0)};
        for (double rtol = 1e-4; rtol > 5e-11; rtol *= 1e-2) {
            plant p = pushed_by_two(of.V, of.soft, of.gap, &laws[0], &laws[1]);
            p.contact[0].gap = -of.over;
            must_go(&p, rtol, end);
            const double off = off_by(&p, end, -1.0, 0.0, forces_of_springs, &of);
            CHECK(off < rtol, "n %g, rtol %g: forces off by %g", of.n, rtol, off);
            release(&p);
        }
    }
}

/* u by (c1 + c2) u' + (k1 + k2 + 1 / soft) u = (k1 + k2) V t + (c1 + c2) V - k2 gap, from u at a time: a line and a
 * decay. count: of the contacts that press. */
static double crept(const pushes *of, int count, double from, double u, double t, double *rate)
{
    const double k = of->k[0] + (count > 1 ? of->k[1] : 0.0), c = of->c[0] + (count > 1 ? of->c[1] : 0.0);
    const double stiff = k + 1.0 / of->soft, speed = k * of->V / stiff;
    const double line = (c * (of->V - speed) - (count > 1 ? of->k[1] * of->gap : 0.0)) / stiff;
    const double left = (u - line - speed * from) * exp(-stiff / c * (t - from));
    *rate = speed - stiff / c * left;
    return line + speed * t + left;
}

static void forces_of_dampers(const void *data, double t, double *force)
{
    const pushes *of = data;
    const int second = t >= of->touch;
    double rate;
    const double start = second ? of->touch : 0.0, there = second ? of->V * start - of->gap : 0.0;
    const double u = crept(of, 1 + second, start, there, t, &rate);
    force[0] = of->k[0] * (of->V * t - u) + of->c[0] * (of->V - rate);
    force[1] = second ? of->k[1] * (of->V * t - of->gap - u) + of->c[1] * (of->V - rate) : 0.0;
}

/* When a first dashpot has pushed the place over the gap; crept() is at touch then. */
static void find_touch(pushes *of, double end, int beyond)
{
    double rate, late = end;
    while (late - of->touch > 1e-15 * end) {
        const double middle = 0.5 * (of->touch + late), u = crept(of, 1, 0.0, 0.0, middle, &rate);
        *((beyond ? u : of->V * middle - u) < of->gap ? &of->touch : &late) = middle;
    }
}

/* With dashpots the place goes on from where it was, and the forces on it jump. */
static void a_second_damper_takes_its_share_at_once(void)
{
    const double end = 1e-4;
    pushes of = {.V = 1.0, .k = {1e7, 3e7}, .c = {2e3, 5e3}, .soft = 1e-8, .gap = 2e-5};
    const aoi_law laws[] = {law_named("kelvin_voigt", 2, of.k[0], of.c[0], 0.0),
                            law_named("kelvin_voigt", 2, of.k[1], of.c[1], 0.0)};
    find_touch(&of, end, 0);
    for (double rtol = 1e-4; rtol > 5e-11; rtol *= 1e-2) {
        plant p = pushed_by_two(of.V, of.soft, of.gap, &laws[0], &laws[1]);
        must_go(&p, rtol, end);
        CHECK(near(moment_of(&p, 1, AOI_TRACK_BEGINS), of.touch, rtol), "rtol %g: touch at %.12g, not %.12g", rtol,
              moment_of(&p, 1, AOI_TRACK_BEGINS), of.touch);
        const double off = off_by(&p, end, of.touch, rtol * of.touch, forces_of_dampers, &of);
        CHECK(off < 10.0 * rtol, "rtol %g: forces off by %g", rtol, off);
        release(&p);
    }
}

/* A dashpot beyond a gap brakes the place: its force is largest where it begins, c2 u' with (c1 + c2) u' = c1 V +
 * k1 (V t - u) - u / soft. */
static void a_force_that_jumps_has_its_peak_there(void)
{
    const double end = 1e-4;
    pushes of = {.V = 1.0, .k = {1e5, 1e5}, .c = {2e3, 5e3}, .soft = 1e-8, .gap = 1e-5};
    const aoi_law laws[] = {law_named("kelvin_voigt", 2, of.k[0], of.c[0], 0.0),
                            law_named("kelvin_voigt", 2, of.k[1], of.c[1], 0.0)};
    find_touch(&of, end, 1);
    const double push = of.c[0] * of.V + of.k[0] * (of.V * of.touch - of.gap) - of.gap / of.soft;
    const double peak = of.c[1] * push / (of.c[0] + of.c[1]);
    CHECK(of.touch < 0.9 * end && peak > 0.0, "it comes there");
    for (double rtol = 1e-4; rtol > 5e-9; rtol *= 1e-2) {
        plant p = pushed_by_two(of.V, of.soft, of.gap, &laws[0], &laws[1]);
        p.contact[1] = (aoi_contact){{0, 2}, {0, 0}, of.gap, &laws[1], NULL, NULL};
        p.part[2].v[0] = 0.0;
        must_go(&p, rtol, end);
        CHECK(near(aoi_adaptive_peak(p.run, 1).force, peak, 10.0 * rtol), "rtol %g: peak %.12g, not %.12g", rtol,
              aoi_adaptive_peak(p.run, 1).force, peak);
        CHECK(near(aoi_adaptive_peak(p.run, 1).time, of.touch, 10.0 * rtol), "rtol %g: at %.12g, not %.12g", rtol,
              aoi_adaptive_peak(p.run, 1).time, of.touch);
        release(&p);
    }
}

/* A load that sets in at once on a place held by a dashpot, c u' = load - u / soft - k u, until u is at something beyond
 * a gap, before or after the dashpot in the order of the scene. */
static void a_dashpot_under_a_sudden_load_keeps_its_place_from_others(void)
{
    const double soft = 1e-4, k = 3e7, c = 5e3, load = 4e3, gap = 1e-6, end = 1e-4, fall = (1.0 / soft + k) / c;
    const double touch = -log1p(-gap * (1.0 / soft + k) / load) / fall;
    const aoi_law held = law_named("kelvin_voigt", 2, k, c, 0.0);
    const aoi_law laws[] = {hertz(1e9), law_named("hunt_crossley", 3, 1e9, 0.5, 1.5), held};
    for (int i = 0; i < 6; i++) {
        plant p = pushed_by_two(0.0, soft, 0.0, &held, &held);
        p.part[0].load_count = 1;
        p.part[0].load_force[0] = load;
        p.contact[i % 2] = (aoi_contact){{0, 1}, {0, 0}, 0.0, &held, NULL, NULL};
        p.contact[1 - i % 2] = (aoi_contact){{0, 2}, {0, 0}, gap, &laws[i / 2], NULL, NULL};
        must_go(&p, 1e-8, end);
        CHECK(near(aoi_adaptive_peak(p.run, i % 2).force, load, 1e-9), "%d: it begins with %.12g N", i,
              aoi_adaptive_peak(p.run, i % 2).force);
        CHECK(near(moment_of(&p, 1 - i % 2, AOI_TRACK_BEGINS), touch, 1e-8), "touch at %.12g, not %.12g",
              moment_of(&p, 1 - i % 2, AOI_TRACK_BEGINS), touch);
        release(&p);
    }
}

/* The same under a stiff law whose dashpot vanishes at the touch: k d (1 + chi d') = load - d / soft, so that
 * t = -(k chi / s) (d + (load / s) ln(1 - s d / load)) with s = k + 1 / soft. The force falls from the
 * whole load like the square root of time; what follows is slow, and takes few steps. What falls
 * within 1e-22 of the record is not seen. */
static void a_load_sets_in_on_a_stiff_law(double soft)
{
    const double k = 1e9, load = 100.0, end = 1e-3, s = k + 1.0 / soft;
    for (double chi = 1e-2; chi < 1e5; chi *= 1e3) {
        const aoi_law law = law_named("hunt_crossley", 3, k, chi, 1.0);
        const double unseen = sqrt(2.0 * 1e-22 * end / (k * chi * load)) / soft; /* share of the load */
        for (double rtol = 1e-3; rtol > 5e-9; rtol *= 0.1) {
            plant p = ball_on_wall(1e12, 0.0, &law);
            part *place = &p.part[0];
            place->massless = 1;
            place->residual[0] = soft;
            place->load_count = 1;
            place->load_force[0] = load;
            must_go(&p, rtol, end);
            CHECK(near(aoi_adaptive_peak(p.run, 0).force, load, fmax(rtol, 1e-7) + unseen), "it begins with %.12g N",
                  aoi_adaptive_peak(p.run, 0).force);
            CHECK(aoi_adaptive_peak(p.run, 0).time < 1e-11 && p.run->steps < 200, "at %g s, %zu steps",
                  aoi_adaptive_peak(p.run, 0).time, p.run->steps);
            CHECK(open_sampler(&p) == AOI_OK, "sampled");
            for (double share = 0.05; share < 1.0; share += 0.1) {
                const double d = share * load / s, t = -k * chi / s * (d + load / s * log1p(-share));
                const double found = force_at(&p, 0, fmin(t, end)), wanted = load - d / soft;
                CHECK(t > end || near(found, wanted, rtol), "t %g: %.12g N, not %.12g", t, found, wanted);
            }
            release(&p);
        }
    }
}

/* A faster body that comes from behind draws the place away from a first one, whose force is cut at once. */
static void a_faster_one_takes_all_the_force(void)
{
    const double end = 4e-5, fast = 4.0;
    pushes of = {.V = 1.0, .k = {1e5, 1e5}, .c = {2e3, 5e3}, .soft = 1e-8, .gap = 5e-5};
    const aoi_law laws[] = {law_named("kelvin_voigt", 2, of.k[0], of.c[0], 0.0),
                            law_named("kelvin_voigt", 2, of.k[1], of.c[1], 0.0)};
    double rate, touch = 0.0, late = end;
    while (late - touch > 1e-15 * end) {
        const double middle = 0.5 * (touch + late);
        *(fast * middle - crept(&of, 1, 0.0, 0.0, middle, &rate) < of.gap ? &touch : &late) = middle;
    }
    const double u = fast * touch - of.gap, after = fast - u / of.soft / of.c[1];
    CHECK(of.c[0] * (of.V - after) + of.k[0] * (of.V * touch - u) < 0.0, "the first would pull");
    const double stiff = of.k[1] + 1.0 / of.soft, speed = of.k[1] * fast / stiff;
    const double line = (of.c[1] * (fast - speed) - of.k[1] * of.gap) / stiff;
    for (double rtol = 1e-4; rtol > 5e-9; rtol *= 1e-2) {
        plant p = pushed_by_two(of.V, of.soft, of.gap, &laws[0], &laws[1]);
        p.part[2].v[0] = fast;
        must_go(&p, rtol, touch + 2e-6);
        CHECK(open_sampler(&p) == AOI_OK, "sampled");
        for (int i = 1; i <= 20; i++) {
            const double t = touch + 1e-7 * i;
            const double there = line + speed * t + (u - line - speed * touch) * exp(-stiff / of.c[1] * (t - touch));
            const double left = force_at(&p, 0, t), found = force_at(&p, 1, t);
            CHECK(left == 0.0, "rtol %g: the first has let go: %g N", rtol, left);
            CHECK(near(found, there / of.soft, 10.0 * rtol), "rtol %g: %.12g N, not %.12g", rtol, found,
                  there / of.soft);
        }
        release(&p);
    }
}

/* A load presses a place on a dashpot beyond a gap, c u' + k1 (u - gap) + k2 (u + W t) + u / soft = load from u = gap, until a
 * body that comes with a spring takes the load: from there k2 (u + W t) + u / soft = load. */
static void a_spring_takes_a_load_from_a_dashpot(void)
{
    const double W = 3.0, k[] = {1e5, 1e7}, c = 100.0, soft = 1e-8, gap = 3e-5, load = 4e3, end = 1e-4;
    const double stiff = k[0] + k[1] + 1.0 / soft, speed = -k[1] * W / stiff;
    const double line = (load + k[0] * gap - c * speed) / stiff;
    const aoi_law laws[] = {law_named("kelvin_voigt", 2, k[0], c, 0.0), linear(k[1])};
    double over = 0.0, late = end;
    while (late - over > 1e-15 * end) {
        const double t = 0.5 * (over + late), u = line + speed * t + (gap - line) * exp(-stiff / c * t);
        *(load - u / soft - k[1] * (u + W * t) > 0.0 ? &over : &late) = t;
    }
    CHECK(over > 0.0 && over < 0.5 * end, "it does, at %g", over);
    for (double rtol = 1e-4; rtol > 5e-11; rtol *= 1e-2) {
        plant p = pushed_by_two(0.0, soft, 0.0, &laws[0], &laws[1]);
        p.contact[0] = (aoi_contact){{0, 1}, {0, 0}, gap, &laws[0], NULL, NULL};
        p.contact[1] = (aoi_contact){{0, 2}, {0, 0}, 0.0, &laws[1], NULL, NULL};
        p.part[2].v[0] = -W;
        p.part[0].load_count = 1;
        p.part[0].load_force[0] = load;
        must_go(&p, rtol, end);
        CHECK(open_sampler(&p) == AOI_OK, "sampled");
        for (int i = 1; i <= 100; i++) {
            const double t = 0.01 * i * end, after = (load - k[1] * W * t) / (1.0 / soft + k[1]);
            const double u = t < over ? line + speed * t + (gap - line) * exp(-stiff / c * t) : after;
            const double forces[] = {load - u / soft - k[1] * (u + W * t), k[1] * (u + W * t)};
            for (int j = 0; j < 2; j++) {
                const double found = force_at(&p, j, t);
                CHECK(fabs(found - forces[j]) < 10.0 * rtol * load, "rtol %g, t %g, contact %d: %.12g N, not %.12g",
                      rtol, t, j, found, forces[j]);
            }
        }
        release(&p);
    }
}

/* A law made so that a massless place between it and Hunt and Crossley's moves on evenly. */
static void even_push(const aoi_law *law, const double *memory, int piece, double d, double rate, aoi_law_value *value)
{
    const double root = d > 0.0 ? sqrt(d) : 0.0;
    (void)memory;
    (void)piece;
    (void)rate;
    value->force = d > 0.0 ? law->parameter[0] * root * d + law->parameter[1] * d : 0.0;
    value->stiffness = d > 0.0 ? 1.5 * law->parameter[0] * root + law->parameter[1] : 0.0;
    value->damping = 0.0;
}

static double even_potential(const aoi_law *law, const double *memory, double d)
{
    (void)memory;
    return d > 0.0 ? 0.4 * law->parameter[0] * d * d * sqrt(d) + 0.5 * law->parameter[1] * d * d : 0.0;
}

/* Between a body that nothing stops and a wall: u = a t where what pushes it, k1 d^(3/2) + s d at d = (v - a) t,
 * is k2 u^(3/2) (1 + chi a) and what bends it, u / c. */
static void a_massless_place_between_two_contacts_moves_evenly(void)
{
    const double v = 1.0, a = 0.4, k = 1e9, chi = 0.5, c = 7e-7, end = 2e-5, u = a * end;
    const double ratio = a / (v - a);
    aoi_law push = {.force = even_push, .potential = even_potential, .limit = HUGE_VAL};
    push.parameter[0] = k * ratio * sqrt(ratio) * (1.0 + chi * a);
    push.parameter[1] = ratio / c;
    const aoi_law damper = law_named("hunt_crossley", 3, k, chi, 1.5);
    for (double rtol = 1e-3; rtol > 1e-10; rtol *= 0.1) {
        plant p = {.bodies = 0};
        add_rigid(&p, 1e9, v);
        add_place(&p, 1e12, 2, c);
        add_wall(&p);
        join(&p, 0, 0, 1, 0, 0.0, &push);
        join(&p, 1, 1, 2, 0, 0.0, &damper);
        must_go(&p, rtol, end);
        const double force = k * u * sqrt(u) * (1.0 + chi * a);
        CHECK(near(aoi_adaptive_peak(p.run, 1).force, force, rtol), "rtol %g: %.12g, not %.12g", rtol,
              aoi_adaptive_peak(p.run, 1).force, force);
        CHECK(near(aoi_adaptive_peak(p.run, 1).impulse, 0.4 * force * end, rtol), "rtol %g: impulse", rtol);
        release(&p);
    }
}

/* A ball pressed by o on a massless platform that leans on a wall: the platform is at c (F - G), so that
 * F = k (o - c (F - G)) and G = k c (F - G). */
static void what_presses_on_a_massless_place_is_shared_from_the_start(void)
{
    const double k = 2.5e6, c = 3e-6, o = 1e-4, difference = k * o / (1.0 + 2.0 * k * c);
    const double wanted[] = {k * (o - c * difference), k * c * difference};
    const aoi_law law = linear(k);
    plant p = {.bodies = 0};
    add_rigid(&p, 0.4, 0.0);
    add_place(&p, 1e12, 1, c);
    add_wall(&p);
    join_rigid(&p, 0, 1, -o, &law);
    join_rigid(&p, 1, 2, 0.0, &law);
    must_go(&p, 1e-10, 1e-3);
    CHECK(open_sampler(&p) == AOI_OK, "sampled");
    for (int i = 0; i < 2; i++) {
        const double force = force_at(&p, i, 0.0);
        CHECK(near(force, wanted[i], 1e-12), "contact %d: %.15g N, not %.15g", i, force, wanted[i]);
    }
    release(&p);
}

static aoi_law any_damper(uint64_t *seed)
{
    const double k = pow(10.0, 5.0 + 2.0 * uniform(seed));
    return law_named("kelvin_voigt", 2, k, pow(10.0, 6.0 * uniform(seed)), 0.0);
}

/* The place's own spring takes the sum of the forces, by a displacement that does not jump: what strikes it takes over
 * a share, of a strong dashpot as of a weak one, and the first has its peak there. */
static void what_strikes_a_place_only_shares_out_its_force(void)
{
    const double gap = 1e-5, V = 1.0, rtol = 1e-8, end = 20.0 * gap / V;
    uint64_t seed = 25;
    for (int i = 0; i < 60; i++) {
        const double soft = pow(10.0, -9.0 + 3.0 * uniform(&seed));
        const aoi_law first = any_damper(&seed), second = any_damper(&seed);
        plant p = pushed_by_two(V, soft, gap, &first, &second);
        must_go(&p, rtol, end);
        CHECK(open_sampler(&p) == AOI_OK, "sampled");
        const double touch = moment_of(&p, 1, AOI_TRACK_BEGINS), before = force_at(&p, 0, touch * (1.0 - 1e-13));
        const double after = force_at(&p, 0, touch) + force_at(&p, 1, touch);
        const double largest = fmax(aoi_adaptive_peak(p.run, 0).force, aoi_adaptive_peak(p.run, 1).force);
        CHECK(fabs(after - before) < 10.0 * rtol * largest, "%d: %.12g after %.12g", i, after, before);
        CHECK(aoi_adaptive_peak(p.run, 1).force >= force_at(&p, 1, touch), "%d: a peak from the start on", i);
        release(&p);
    }
}

/* A body that a load presses on a wall starts from rest; as the load falls evenly, the force is the load and a ringing:
 * with s = k / (1 + k c) and w^2 = s / m, f = F (1 - a t) + F a (1 - s c) / w sin(w t). */
static void a_preloaded_contact_rings_as_its_load_falls(void)
{
    const double k = 2.5e6, c = 3e-7, mass = 0.4, load = 700.0, rtol = 1e-9, series = k / (1.0 + k * c);
    const double w = sqrt(series / mass), end = 0.2 * PI / w, fall = 0.5 / end;
    const aoi_law law = linear(k);
    plant p = {.bodies = 0};
    part *place = add_place(&p, mass, 1, c);
    add_wall(&p);
    join(&p, 0, 0, 1, 0, 0.0, &law);
    place->x[0] = load / k;
    place->load_count = 2;
    place->load_time[1] = end;
    place->load_force[0] = load;
    place->load_force[1] = 0.5 * load;
    p.rested = 1;
    must_go(&p, rtol, end);
    CHECK(open_sampler(&p) == AOI_OK, "sampled");
    for (int i = 0; i <= 20; i++) {
        double found;
        const double t = 0.05 * i * end, rings = load * fall * (1.0 - series * c) / w * sin(w * t);
        aoi_sampler_forces(p.sampler, t, &found, 1);
        CHECK(fabs(found - (load * (1.0 - fall * t) + rings)) < 10.0 * rtol * load, "t %g: %.12g N, not %.12g", t, found,
              load * (1.0 - fall * t) + rings);
    }
    release(&p);
}

/* A place at touch between a body that strikes it and one that flies on before it, to which it catches up: all forces
 * balance, k1 (V t - u)^(3/2) = u / soft + k2 (u - w t)^(3/2), the last only where it presses. */
static void a_place_that_is_struck_catches_up_with_what_flies_on(void)
{
    const double V = 3.5, w = 1.5, k[] = {1e9, 1e8}, soft = 1e-5, end = 1e-4;
    const aoi_law laws[] = {hertz(k[0]), hertz(k[1])};
    double low = w * end, high = V * end;
    for (int i = 0; i < 100; i++) {
        const double u = 0.5 * (low + high);
        *(k[0] * pow(V * end - u, 1.5) > u / soft + k[1] * pow(u - w * end, 1.5) ? &low : &high) = u;
    }
    const double wanted[] = {k[0] * pow(V * end - low, 1.5), k[1] * pow(low - w * end, 1.5)};
    for (double rtol = 1e-4; rtol > 5e-11; rtol *= 1e-2) {
        plant p = pushed_by_two(V, soft, 0.0, &laws[0], &laws[1]);
        p.contact[1] = (aoi_contact){{0, 2}, {0, 0}, 0.0, &laws[1], NULL, NULL};
        p.part[2].v[0] = w;
        must_go(&p, rtol, end);
        for (size_t c = 0; c < 2; c++) {
            CHECK(near(p.run->contact[c].closed.force, wanted[c], rtol), "rtol %g: contact %zu has %.12g N, not %.12g", rtol, c,
                  p.run->contact[c].closed.force, wanted[c]);
        }
        release(&p);
    }
}

/* A ball that leaves a place has had its peak: what strikes the place shortly before, or as it leaves, does not change
 * it. */
static void what_strikes_late_leaves_the_peak_before(void)
{
    const aoi_law law = law_named("kuwabara_kono", 2, 17130.0, 7.7e-4, 0.0), late = hertz(75420.0);
    double peak = 0.0, left = 0.06;
    for (int i = 0; i <= 40; i++) { /* at first alone */
        plant p = {.bodies = 0};
        add_place(&p, 1e12, 1, 2e-8);
        add_rigid(&p, 2.0, 10.0);
        add_rigid(&p, 13.0, 10.0);
        join(&p, 1, 0, 0, 0, 0.0, &law);
        join(&p, 2, 0, 0, 0, i == 0 ? 1.0 : 10.0 * left * (0.8 + 0.005 * i), &late);
        must_go(&p, 1e-8, 1.5 * left);
        const double found = aoi_adaptive_peak(p.run, 0).force;
        CHECK(i == 0 || near(found, peak, 1e-8), "%d: peak %.12g N, not %.12g", i, found, peak);
        peak = i == 0 ? found : peak;
        left = i == 0 ? moment_of(&p, 0, AOI_TRACK_ENDS) : left;
        release(&p);
    }
}

int main(void)
{
    a_preloaded_contact_rings_as_its_load_falls();
    what_a_force_bends_touches_elsewhere();
    a_second_spring_takes_its_share_at_once();
    a_second_damper_takes_its_share_at_once();
    a_force_that_jumps_has_its_peak_there();
    a_dashpot_under_a_sudden_load_keeps_its_place_from_others();
    a_load_sets_in_on_a_stiff_law(1e-5);
    a_load_sets_in_on_a_stiff_law(1e-10);
    a_faster_one_takes_all_the_force();
    a_spring_takes_a_load_from_a_dashpot();
    a_massless_place_between_two_contacts_moves_evenly();
    what_presses_on_a_massless_place_is_shared_from_the_start();
    what_strikes_a_place_only_shares_out_its_force();
    a_place_that_is_struck_catches_up_with_what_flies_on();
    what_strikes_late_leaves_the_peak_before();
    return check_report();
}
