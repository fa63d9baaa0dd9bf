// A path tracer of one file: a room with a window of a BSDF, light from the sky, a picture as PPM on standard output.
//
//   c++ -O2 -std=c++17 render.cpp $(pkg-config --cflags --libs bsdftree) -o render && ./render blinds.xml 64 > room.ppm
//
// The room is 4 m wide, 3 m high and 5 m deep; its far wall, which we look at, has the window, whose front is the room. Walls are diffuse.
// At the window a path goes on as the BSDF says; what leaves through it meets a sky that is brighter towards the zenith, and a dark ground.
#include <bsdftree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

namespace {

using Vector = std::array<double, 3>;
constexpr double PI = 3.14159265358979323846;
constexpr int WIDTH = 192, HEIGHT = 144, BOUNCES = 8;
// Half the width, half the height, the depth; the window's half width, its lower and upper edge.
constexpr double ROOM[3] = {2.0, 1.5, 5.0}, WINDOW[3] = {1.8, -0.8, 1.3};
constexpr double WALLS = 0.7, EXPOSURE = 2.5;

struct Hit {
    double t;
    int axis;
    bool window;
};

// Where a ray inside the room meets its wall.
Hit meet(const Vector &o, const Vector &d)
{
    const double low[3] = {-ROOM[0], -ROOM[1], 0.0}, high[3] = {ROOM[0], ROOM[1], ROOM[2]};
    Hit hit{1e30, 0, false};
    for (int a = 0; a < 3; a++) {
        if (d[a] == 0.0)
            continue;
        const double t = ((d[a] > 0.0 ? high[a] : low[a]) - o[a]) / d[a];
        if (t < hit.t)
            hit = {std::max(t, 0.0), a, false};
    }
    if (hit.axis == 2 && d[2] > 0.0) {
        const double x = o[0] + hit.t * d[0], y = o[1] + hit.t * d[1];
        hit.window = std::abs(x) < WINDOW[0] && y > WINDOW[1] && y < WINDOW[2];
    }
    return hit;
}

double sky(const Vector &d)
{
    return d[1] > 0.0 ? 1.0 + 2.0 * d[1] : 0.2;
}

// The window's front looks into the room, along -z of the room; its up is the room's.
Vector to_window(const Vector &v) { return {-v[0], v[1], -v[2]}; }

double radiance(const bsdftree_band *band, Vector o, Vector d, std::mt19937 &random)
{
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    double weight = 1.0;
    for (int bounce = 0; bounce < BOUNCES; bounce++) {
        const Hit hit = meet(o, d);
        for (int a = 0; a < 3; a++)
            o[a] += hit.t * d[a];
        if (hit.window) {
            // Directions of a BSDF point away from it: back to where the ray comes from.
            const Vector back = to_window({-d[0], -d[1], -d[2]});
            const auto sample = bsdftree_sample(band, back.data(), uniform(random), BSDFTREE_ALL);
            if (sample.pdf <= 0.0)
                return 0.0;
            weight *= sample.weight;
            d = to_window({sample.exitant[0], sample.exitant[1], sample.exitant[2]});
            if (d[2] > 0.0)
                return weight * sky(d);
            continue;
        }
        // Diffuse: cosine-weighted about the wall's normal.
        const double r2 = uniform(random), phi = 2.0 * PI * uniform(random), r = std::sqrt(r2);
        const double inward = d[hit.axis] > 0.0 ? -1.0 : 1.0;
        d[hit.axis] = inward * std::sqrt(1.0 - r2);
        d[(hit.axis + 1) % 3] = r * std::cos(phi);
        d[(hit.axis + 2) % 3] = r * std::sin(phi);
        weight *= WALLS;
    }
    return 0.0;
}

} // namespace

int main(int argc, char **argv)
{
    if (argc < 2) {
        std::fprintf(stderr, "usage: %s BSDF.xml [SAMPLES] > room.ppm\n", argv[0]);
        return 2;
    }
    const int samples = argc > 2 ? std::max(1, std::atoi(argv[2])) : 64;
    bsdftree *bsdf;
    char message[1024];
    if (bsdftree_load(argv[1], 0, &bsdf, message, sizeof message) != BSDFTREE_OK) {
        std::fprintf(stderr, "%s\n", message);
        return 1;
    }
    const bsdftree_band *band = bsdftree_find_band(bsdf, nullptr);
    if (!band)
        return 1;
    std::printf("P6\n%d %d\n255\n", WIDTH, HEIGHT);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (int j = 0; j < HEIGHT; j++) {
        std::mt19937 random(static_cast<unsigned>(j));
        for (int i = 0; i < WIDTH; i++) {
            double sum = 0.0;
            for (int k = 0; k < samples; k++) {
                Vector d = {(i + uniform(random)) / WIDTH * 2.0 - 1.0,
                            (1.0 - (j + uniform(random)) / HEIGHT * 2.0) * HEIGHT / WIDTH, 1.5};
                const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
                for (double &c : d)
                    c /= length;
                sum += radiance(band, {0.0, 0.0, 0.3}, d, random);
            }
            const double shown = std::pow(std::min(1.0, EXPOSURE * sum / samples), 1.0 / 2.2);
            const auto byte = static_cast<unsigned char>(255.0 * shown + 0.5);
            for (int c = 0; c < 3; c++)
                std::fputc(byte, stdout);
        }
    }
    bsdftree_free(bsdf);
}
