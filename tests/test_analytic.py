"""Pictures whose values are known in closed form, by the engine and, to check the expectations, by the reference."""

import numpy as np
import pytest

from tests.brute import scenes as s
from tests.brute.harness import engine, reference

# many shadow rays and no photons, where nothing but direct light is asked
STRAIGHT = {"passes": 32, "light_samples": 16, "caustic_photons": 0, "diffuse_photons": 0}
LIGHT = "Direct+Caustic+Diffuse+Emission+Environment"


@pytest.fixture(params=["reference", "engine"])
def picture(request):
    """A function (scene, spp, photons, **engine settings) -> Batches; each case runs with both tracers."""

    def by_reference(scene, spp=64, photons=0, shadow_rays=True, **_settings):
        return reference(scene, spp, photons, shadow_rays=shadow_rays)

    def by_engine(scene, spp=64, photons=0, shadow_rays=True, passes=8, **settings):
        return engine(scene, passes, **settings)[0]

    return by_reference if request.param == "reference" else by_engine


def check(value, expected, tolerance):
    """Fail unless the value agrees within the relative tolerance and four standard errors."""
    noise = "" if value.error <= tolerance * abs(expected) else ": too noisy for a verdict"
    assert value.agrees(expected, tolerance), f"{value}, expected {expected:.6g} within {tolerance:.1%}{noise}"


def seen_at(point, normal, half_width=0.02, distance=0.3, slant=60.0):
    """A parallel camera on a small square of surface around a point, `slant` degrees off its normal."""
    n = np.asarray(normal, float)
    side = np.cross(n, (0.31, 0.77, 0.55))
    side /= np.linalg.norm(side)
    a = np.radians(slant)
    eye = np.asarray(point, float) + distance * (np.cos(a) * n + np.sin(a) * side)
    return s.camera(eye, point, half_width, kind="ORTHO")


def fresnel(cos_i, n):
    """Reflectance of unpolarised light [Hecht, Optics, 4.6]; n = n_t / n_i."""
    cos_t = np.sqrt(np.maximum(0.0, 1 - (1 - np.square(cos_i)) / n**2))
    rs = (cos_i - n * cos_t) / (cos_i + n * cos_t)
    rp = (n * cos_i - cos_t) / (n * cos_i + cos_t)
    return 0.5 * (rs**2 + rp**2)


# ---- furnace


@pytest.mark.parametrize("albedo", [0.2, 0.5, 0.8])
def test_furnace(picture, albedo):
    """A closed box of albedo a and emission e: L = e / (1 - a) = e + a e + a^2 e / (1 - a), pass by pass."""
    wall = s.mixed(s.diffuse(albedo), s.emitter(0.7), add=True)
    # the middle of a wall: photon gathers near an edge miss what lies beyond it
    view = s.camera((0.1, -0.2, 0.1), (0.1, 1.0, 0.1), 0.3)
    scene = s.build([(s.box((-1, -1, -1), (1, 1, 1), inward=True), wall)], (), view, picture=s.frame(16))
    got = picture(scene, 512, shadow_rays=False, passes=16, light_samples=16, diffuse_photons=300_000)
    check(got.value("Emission"), 0.7, 1e-5)
    check(got.value("Direct"), albedo * 0.7, 0.005)
    check(got.value("Diffuse"), albedo**2 * 0.7 / (1 - albedo), 0.01)
    check(got.value(LIGHT), 0.7 / (1 - albedo), 0.005)


@pytest.mark.parametrize("gather", ["GLOSSY", "ALL"])
def test_furnace_is_even_in_corners_and_around_things(gather):
    """The same radiance at every pixel, by the default radii: no dark line where walls meet or things stand or end.

    Without regard to edges the means are 3.7% and 5.1% low, and 7% of the pixels off by more than noise and 6%; they
    are 0.5% and 0.0% low, with 1.2% and none off: small things lose some light while the radius is as large as they.
    """
    albedo = 0.5
    wall = s.mixed(s.diffuse(albedo), s.emitter(0.7), add=True)
    things = [
        s.box((-1, -1, -1), (1, 1, 1), inward=True),
        s.box((-0.5, 0.3, -1), (0.1, 0.7, -0.5)),  # on the floor
        s.quad((0.6, 0.2, -0.6), (0.25, 0.1, 0), (0, 0.25, 0.05)),  # a free sheet
        s.sphere((-0.7, -0.05, -0.8), 0.2),
        s.box((-0.9, 0.85, -1.2), (-0.6, 0.9, 0.5)),  # a slab through the floor, thinner than the radius, near a wall
    ]
    view = s.camera((0.3, -0.9, 0.6), (-0.1, 0.9, -0.75), 0.8)
    scene = s.build([(thing, wall) for thing in things], (), view, picture=s.frame(32))
    got, _ = engine(scene, 16, light_samples=1, final_gather=gather, diffuse_photons=30_000)
    diffuse = got["Diffuse"].mean(axis=3) / (albedo**2 * 0.7 / (1 - albedo))
    mean, error = diffuse.mean(axis=0), diffuse.std(axis=0, ddof=1) / 4.0
    off = abs(mean - 1.0) > 0.06 + 3.0 * error
    assert abs(mean.mean() - 1.0) < 0.01 and off.mean() < 0.02


# ---- form factors


@pytest.mark.parametrize("offset", [0.0, 0.7, 1.8])
@pytest.mark.parametrize("kind", ["lamp", "mesh"])
def test_element_to_parallel_disk(picture, kind, offset):
    """Irradiance under a disk of radius r at height h, `offset` beside its axis [Howell, configuration B-12]."""
    r, h, le = 0.6, 0.8, 2.0
    a = max(offset, 1e-9)
    z = 1 + (h / a) ** 2 + (r / a) ** 2
    factor = 0.5 * (1 - (z - 2 * (r / a) ** 2) / np.sqrt(z**2 - 4 * (r / a) ** 2)) if offset else r**2 / (r**2 + h**2)
    floor = (s.quad((0, 0, 0), (4, 0, 0), (0, 4, 0)), s.diffuse(0.5))
    view = seen_at((offset, 0, 0), (0, 0, 1), 0.01, 0.2)
    if kind == "lamp":
        lamp = s.area_lamp((0, 0, h), (0, 0, 0), 2 * r, le * np.pi * np.pi * r**2, "DISK")
        scene = s.build([floor], [lamp], view, picture=s.frame(16))
    else:
        disk = s.mesh(*fan((0, 0, h), r))
        scene = s.build([floor, (disk, s.emitter(le))], (), view, picture=s.frame(16))
    check(picture(scene, 256, **STRAIGHT).value("Direct"), 0.5 * le * factor, 0.01)


def fan(centre, radius, n=256):
    """Positions and triangles of a regular polygon with the area of a disk, facing down."""
    t = 2 * np.pi * np.arange(n) / n
    radius = radius * np.sqrt(2 * np.pi / n / np.sin(2 * np.pi / n))
    ring = np.stack([radius * np.cos(t), radius * np.sin(t), 0 * t], 1) + centre
    triangles = [(n, (i + 1) % n, i) for i in range(n)]
    return np.vstack([ring, [centre]]), triangles


@pytest.mark.parametrize("y", [0.25, 0.5, 1.5])
def test_element_to_perpendicular_rectangle(picture, y):
    """Irradiance of the floor at distance y from the foot of a wall a wide and c high [Howell, configuration B-4].

    F = (atan(1/Y) - Y / sqrt(X^2 + Y^2) atan(1 / sqrt(X^2 + Y^2))) / (2 pi), X = c / b, Y = y / b, for an element in
    line with the end of a wall of width b; two of them for the middle.
    """
    half, c, le = 0.7, 1.1, 3.0
    xx, yy = c / half, y / half
    root = np.hypot(xx, yy)
    factor = (np.arctan(1 / yy) - yy / root * np.arctan(1 / root)) / np.pi
    wall = (s.quad((0, 0, c / 2), (half, 0, 0), (0, 0, c / 2)), s.emitter(le))
    floor = (s.quad((0, 0, 0), (3, 0, 0), (0, 3, 0)), s.diffuse(0.5))
    scene = s.build([wall, floor], (), seen_at((0, -y, 0), (0, 0, 1), 0.004, 0.1), picture=s.frame(16))
    check(picture(scene, 512, **STRAIGHT).value("Direct"), 0.5 * le * factor, 0.01)


# ---- each light's law of distance


def square_on_axis(half, d):
    """Form factor from an element to a parallel square on its axis [Howell, configuration B-3], four corners."""
    x = half / d
    return 4 / (2 * np.pi) * 2 * x / np.sqrt(1 + x * x) * np.arctan(x / np.sqrt(1 + x * x))


LAMPS = {
    "point": (lambda d: s.point_lamp((0, 0, d), 0.0, 10.0), lambda d: 10 / (4 * np.pi * d * d)),
    "ball": (lambda d: s.point_lamp((0, 0, d), 0.2, 10.0), lambda d: 10 / (4 * np.pi * d * d)),
    "soft ball": (lambda d: s.point_lamp((0, 0, d), 0.2, 10.0, True), lambda d: 10 / (4 * np.pi * (d * d + 0.04))),
    "spot": (lambda d: spot(d, 0.0), lambda d: 10 / (4 * np.pi * d * d)),
    "spot ball": (lambda d: spot(d, 0.1), lambda d: 10 / (4 * np.pi * d * d)),
    "square": (
        lambda d: s.area_lamp((0, 0, d), (0, 0, 0), 0.6, 10.0),
        lambda d: 10 / 0.36 * square_on_axis(0.3, d),
    ),
    "rectangle": (
        lambda d: s.area_lamp((0, 0, d), (0, 0, 0), (0.02, 0.01), 10.0, "RECTANGLE"),
        lambda d: 10 / (np.pi * d * d),
    ),
    "disk": (
        lambda d: s.area_lamp((0, 0, d), (0, 0, 0), 0.6, 10.0, "DISK"),
        lambda d: 10 / (0.09 * np.pi) * 0.09 / (0.09 + d * d),
    ),
    "ellipse": (
        lambda d: s.area_lamp((0, 0, d), (0, 0, 0), (0.02, 0.01), 10.0, "ELLIPSE"),
        lambda d: 10 / (np.pi * d * d),
    ),
    "sun": (lambda d: s.sun_lamp((0, 0, -1), 0.0, 3.0), lambda d: 3.0),
    "wide sun": (lambda d: s.sun_lamp((0, 0, -1), 0.6, 3.0), lambda d: 3.0),
}


def spot(d, radius):
    """A spot that shines straight down; the blend leaves the middle alone."""
    lamp = s.point_lamp((0, 0, d), radius, 10.0)
    lamp.kind, lamp.spot_size, lamp.spot_blend = "SPOT", 1.2, 0.3
    return lamp


@pytest.mark.parametrize("distance", [0.5, 1.0, 4.0])
@pytest.mark.parametrize("kind", LAMPS)
def test_distance_law(picture, kind, distance):
    """Irradiance of a floor straight below a lamp; E = S for the sun at any distance."""
    lamp, irradiance = LAMPS[kind]
    floor = (s.quad((0, 0, 0), (2, 0, 0), (0, 2, 0)), s.diffuse(0.5))
    view = seen_at((0, 0, 0), (0, 0, 1), 0.002, 0.05)
    scene = s.build([floor], [lamp(distance)], view, picture=s.frame(16))
    # the small lamps and patches are not points: (0.02 / 0.5)^2 / 12 each way
    check(picture(scene, 64, **STRAIGHT).value("Direct"), 0.5 / np.pi * irradiance(distance), 0.005)


# ---- smooth glass


@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0, 75.0])
@pytest.mark.parametrize("side", ["reflected", "transmitted"])
def test_pane(picture, side, degrees):
    """A glass pane reflects 2 R / (1 + R) and transmits (1 - R) / (1 + R), R one face's reflectance."""
    n, a = 1.5, np.radians(degrees)
    r = fresnel(np.cos(a), n)
    expected = 2 * r / (1 + r) if side == "reflected" else (1 - r) / (1 + r)
    eye = 3 * np.array([0, -np.sin(a), np.cos(a)])
    pane = (s.box((-20, -20, -0.01), (20, 20, 0)), s.glass(n))
    # a glowing sheet beyond the eye, or below the pane
    glow = (s.quad((0, 0, 8.0 if side == "reflected" else -1.0), (60, 0, 0), (0, 60, 0)), s.emitter(1.0))
    scene = s.build([pane, glow], (), s.camera(eye, (0, 0, 0), 0.01, kind="ORTHO"), picture=s.frame(16))
    check(picture(scene, 256, passes=256, caustic_photons=0, diffuse_photons=0).value("Emission"), expected, 0.02)


def test_snell(picture):
    """The edge of a glowing sheet behind a slab of thickness t is seen displaced by t sin a (1 - cos a / (n cos b))."""
    n, a, t = 1.5, np.radians(50.0), 0.3
    b = np.arcsin(np.sin(a) / n)
    shift = t * np.sin(a) * (1 - np.cos(a) / (n * np.cos(b)))
    slab = (s.box((-9, -9, -t), (9, 9, 0)), s.glass(n))
    # the sheet fills y < 0 at height -1; the eye looks down along +y at the point where its edge is seen without a slab
    glow = (s.quad((0, -4, -1.0), (9, 0, 0), (0, 4, 0)), s.emitter(1.0))
    toward = np.array([0, np.sin(a), -np.cos(a)])
    edge = np.array([0, 0, -1.0])
    view = s.camera(edge - 4 * toward, edge, 0.25, kind="ORTHO")
    got = picture(s.build([slab, glow], (), view, picture=s.frame(32)), 128, passes=64,
                  caustic_photons=0, diffuse_photons=0)
    r = fresnel(np.cos(a), n)
    # each echo inside the slab moves the light by 2 t tan b along the slab
    echo = 2 * t * np.tan(b) * np.cos(a)
    lit = sum((1 - r) ** 2 * r ** (2 * k) * np.clip(0.5 + (shift - k * echo) / 0.5, 0, 1) for k in range(3))
    check(got.value("Emission"), lit, 0.01)


# ---- flux


def test_flux_balance(picture):
    """All light is absorbed by the walls of a closed box: (1 - a) E summed over them is the lamp's power.

    Seen by six parallel cameras a centimetre before the walls. Glass and mirrors without loss hang between.
    """
    albedo, power = 0.4, 10.0
    parts = [
        (s.box((-1, -1, -1), (1, 1, 1), inward=True), s.diffuse(albedo)),
        (s.sphere((0.3, 0.2, -0.4), 0.35), s.glass(1.5)),
        (s.sphere((-0.4, -0.2, -0.1), 0.3), s.mirror(1.0)),
    ]
    lamp = s.area_lamp((0.1, 0.2, 0.9), (0, 0, -1), 0.5, power)
    absorbed, variance = 0.0, 0.0
    for axis in np.vstack([np.eye(3), -np.eye(3)]):
        view = s.camera(0.99 * axis, axis, 1.0, kind="ORTHO")
        got = picture(
            s.build(parts, [lamp], view, picture=s.frame(64)), 16, 100_000, passes=4, caustic_radius=0.5,
            diffuse_radius=0.5,
        ).value("Direct+Caustic+Diffuse")
        absorbed += got.mean * np.pi / albedo * (1 - albedo) * 4
        variance += (got.error * np.pi / albedo * (1 - albedo) * 4) ** 2
    # a gather disk of half a pixel loses, along each edge, what lies beyond the wall: at most 0.5 / 64 of the light
    assert np.sqrt(variance) < 0.005 * power
    assert absorbed == pytest.approx(power, rel=0.01, abs=4 * np.sqrt(variance))


def test_flux_counters():
    """Photons: emitted = absorbed + escaped + dropped to rounding, and emitted = the lamps' powers, each pass.

    A convex glowing mesh sends half of its light into the open; a lamp in a closed room loses none.
    """
    wall = s.mixed(s.diffuse(0.5), s.emitter(0.7), add=True)
    view = s.camera((0.1, -0.2, 0.1), (0.1, 1.0, 0.1), 0.3)
    closed = s.box((-1, -1, -1), (1, 1, 1), inward=True)
    _, mesh = engine(s.build([(closed, wall)], (), view, picture=s.frame(8)), 2)
    balls = [(s.sphere((0.4, 0, 0), 0.3), s.glass(1.5)), (s.sphere((-0.4, 0, 0), 0.3), s.mirror(0.8))]
    lamps = [s.area_lamp((0, 0, 0.9), (0, 0, 0), 0.3, 7.0), s.point_lamp((0, 0.8, 0), 0.0, 3.0)]
    _, lamp = engine(s.build([(closed, s.diffuse(0.5)), *balls], lamps, view, picture=s.frame(8)), 2)
    for statistics, power, lost in ((mesh, 2 * np.pi * 0.7 * 24, 0.5), (lamp, 10.0, 0.0)):
        emitted, absorbed, escaped, dropped = statistics["flux"]["diffuse"][:, 0]
        assert emitted == pytest.approx(2 * power, rel=0.005)
        assert absorbed + escaped + dropped == pytest.approx(emitted, rel=1e-5)
        # 200 000 photons, sides by stratified numbers: noise of the half below 0.2%
        assert escaped == pytest.approx(lost * emitted, rel=0.005, abs=1e-4 * emitted)
        assert dropped < 1e-3 * emitted


# ---- the pool


@pytest.fixture(scope="module")
def water():
    """(n, reflectance at normal incidence, internal reflectance of diffuse light) of flat water."""
    n = 1.333
    c = (np.arange(20000) + 0.5) / 20000
    outside = np.sum(2 * c * fresnel(c, n)) / 20000
    return n, fresnel(1.0, n), 1 - (1 - outside) / n**2


def over_square(half, size, d):
    """Mean form factor from a square of side `size` to a parallel one of half side `half` [Howell, B-3 by corners]."""
    x = (np.arange(200) + 0.5) / 200 * size / 2

    def corner(a, b):
        p, q = np.hypot(1, a), np.hypot(1, b)
        return (a / p * np.arctan(b / p) + b / q * np.arctan(a / q)) / (2 * np.pi)

    a, b = np.meshgrid(np.concatenate([half - x, half + x]) / d, np.concatenate([half - x, half + x]) / d)
    return 4 * corner(a, b).mean()


@pytest.mark.parametrize("lamp", ["sun", "area", "far area"])
def test_pool_floor(picture, water, lamp):
    """A floor of albedo a under still water, lit and seen from straight above.

    Caustic: a / pi (1 - R)^2 E / n^2, since radiance falls by n^2 on leaving the water. Diffuse: light from the floor
    is sent back by the surface with r = 1 - (1 - R_d) / n^2, so all light is 1 / (1 - a r) of that. Mirrors at the
    sides make the pool endless, so the mean over all of it holds for uneven light too.
    """
    n, r0, inside = water
    albedo, irradiance = 0.6, 3.0
    parts = [
        (s.quad((0, 0, -0.5), (0.5, 0, 0), (0, 0.5, 0)), s.diffuse(albedo)),
        (s.quad((0, 0, 0), (0.5, 0, 0), (0, 0.5, 0)), s.glass(n)),
    ]
    for x in (np.array((1.0, 0, 0)), np.array((0, 1.0, 0)), np.array((-1.0, 0, 0)), np.array((0, -1.0, 0))):
        parts.append((s.quad(0.5 * x + (0, 0, -0.25), 0.5 * np.cross((0, 0, 1), x), (0, 0, 0.25)), s.mirror(1.0)))
    # wide lamps, which the reference finds by chance; up to 0.5 rad off the normal 1 - R changes by 0.1%
    light = s.sun_lamp((0, 0, -1), 1.0, irradiance)
    if lamp != "sun":
        d, side = (4.0, 3.0) if lamp == "area" else (40.0, 30.0)
        light = s.area_lamp((0, 0, d), (0, 0, 0), side, irradiance * side**2 / over_square(side / 2, 1.0, d))
    scene = s.build(parts, [light], s.camera((0, 0, 1), (0, 0, 0), 0.5, kind="ORTHO"), picture=s.frame(16))
    radii = {"caustic_radius": 0.5, "diffuse_radius": 0.5}  # gather disks reach under the mirrors: at most 1.6% is lost
    got = picture(scene, 2048, passes=16, diffuse_photons=500_000, **radii)
    caustic = albedo / np.pi * irradiance * (1 - r0) ** 2 / n**2
    tolerance = 0.1 if lamp == "far area" else 0.02  # of the far lamp's photons one in 5000 comes to the pool
    check(got.value("Caustic"), caustic, 0.01)
    check(got.value("Diffuse"), caustic * albedo * inside / (1 - albedo * inside), tolerance)


# ---- shading normals


def tilted(shape, degrees, axis):
    """The mesh with all its shading normals turned about an axis."""
    corner = shape.positions[shape.triangles[0]].astype(float)
    n = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    n /= np.linalg.norm(n)
    a = np.radians(degrees)
    normal = np.cos(a) * n + np.sin(a) * np.cross(axis, n)
    shape.normals = np.broadcast_to(normal, (len(shape.triangles), 3, 3)).astype(np.float32)
    return shape


@pytest.mark.parametrize("degrees", [0.0, 30.0])
def test_beam_of_a_tilted_mirror(picture, degrees):
    """A flat mirror shaded as if turned by 20 degrees throws a beam of the sun's own irradiance by 40 degrees.

    Seen from the lit screen, every direction to the mirror leads to the sun: E is the sun's. Photons fall on the flat
    mirror, whose outline is cos 40 narrower along the beam, so each carries only |ng.wi| / |ng.wo| = cos 40 on. On a
    screen whose own normal is turned by b, radiance is a / pi E cos b, though the flux per area is E
    [Veach 1997, section 5.3].
    """
    beam = np.array([np.sin(np.radians(40)), 0, np.cos(np.radians(40))])
    side = np.cross((0, 1, 0), -beam)
    parts = [
        (tilted(s.quad((0, 0, 0), (0.5, 0, 0), (0, 0.5, 0)), 20, (0, 1, 0)), s.mirror(1.0)),
        (tilted(s.quad(1.5 * beam, 0.2 * side, np.cross(-beam, 0.2 * side)), degrees, (0, 1, 0)), s.diffuse(0.5)),
    ]
    view = seen_at(1.5 * beam, -beam, 0.05, 0.3, 30.0)
    scene = s.build(parts, [s.sun_lamp((0, 0, -1), 0.02, 3.0)], view, picture=s.frame(16))
    got = picture(scene, 16, 4_000_000, diffuse_photons=0, caustic_radius=1.0, passes=32)
    check(got.value("Caustic"), 0.5 / np.pi * 3.0 * np.cos(np.radians(degrees)), 0.015)


def ball_over_floor(segments, smooth):
    """A glass ball close above a floor, a lamp high above; the picture is the floor around the caustic."""
    parts = [
        (s.quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), s.diffuse(0.7)),
        (s.sphere((0, 0, 0.75), 0.4, segments, smooth), s.glass(1.5)),
    ]
    lamp = s.area_lamp((0.4, 0.2, 4.0), (0, 0, 0.5), 0.8, 30.0, "DISK")
    view = s.camera((1.2, -1.2, 0.6), (-0.05, 0, 0), 0.16, clip_start=0.01)
    return s.build(parts, [lamp], view, picture=s.frame(32))


def test_smooth_ball_is_a_ball(picture):
    """The caustic of a smooth-shaded ball of 32 segments is that of a flat-shaded one of 384.

    The coarse ball is an inscribed polyhedron: its outline is 0.5% smaller, its caustic up to 2% weaker.
    """
    options = {"passes": 16, "caustic_photons": 200_000, "diffuse_photons": 0, "caustic_radius": 1.0}
    coarse = picture(ball_over_floor(32, True), 16, 400_000, **options)
    fine = picture(ball_over_floor(384, False), 16, 400_000, **options)
    a, b = coarse.value("Caustic"), fine.value("Caustic")
    assert max(a.error, b.error) < 0.03 * b.mean
    assert abs(a.mean - b.mean) <= 0.03 * b.mean + 4 * np.hypot(a.error, b.error), f"{a} and {b}"


# ---- passes
