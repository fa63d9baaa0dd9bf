// Closest hits per second of Embree's single-ray query, robust mode: the oracle of benches/generate/raw_speed.py.
//
// Enters: a folder with SCENE.triangles (9 f32 each), SCENE.quadrics (an u32 kind and 8 f32 each) and SCENE.KIND.rays (origin,
// direction, least distance: 7 f32 each), as the Rust example `rays` writes them. Leaves: a line "scene kind rays/s hits"
// for each file of rays. Embree has no quadrics: they are user geometry, met in f32 by the textbook formulas.
//
// g++ -O3 -march=native embree.cpp -lembree3

#include <embree3/rtcore.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

struct Vec {
    float x, y, z;
};
static Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static Vec operator*(Vec a, float s) { return {a.x * s, a.y * s, a.z * s}; }
static float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

enum Kind : uint32_t { SPHERE, TAPER, RING };

// Sphere: a centre, r0. Taper (cylinder or cone): ends a and b, r0 at a and r1 at b. Ring: centre a, unit normal b, r0 to r1.
struct Quadric {
    Kind kind;
    Vec a, b;
    float r0, r1;
};

static void bounds(const RTCBoundsFunctionArguments* args) {
    const Quadric& q = static_cast<const Quadric*>(args->geometryUserPtr)[args->primID];
    const float r = std::max(q.r0, q.r1);
    const Vec end = q.kind == TAPER ? q.b : q.a;
    *args->bounds_o = {std::min(q.a.x, end.x) - r, std::min(q.a.y, end.y) - r, std::min(q.a.z, end.z) - r, 0,
                       std::max(q.a.x, end.x) + r, std::max(q.a.y, end.y) + r, std::max(q.a.z, end.z) + r, 0};
}

// Distances at which the ray meets the quadric, unordered; NaN where it does not.
static void roots(const Quadric& q, Vec origin, Vec direction, float t[2]) {
    t[0] = t[1] = NAN;
    if (q.kind == SPHERE) {
        const Vec from = origin - q.a;
        const float half_b = dot(from, direction);
        const float half_chord = std::sqrt(half_b * half_b - dot(from, from) + q.r0 * q.r0);
        t[0] = -half_b - half_chord;
        t[1] = -half_b + half_chord;
    } else if (q.kind == RING) {
        const float at = dot(q.a - origin, q.b) / dot(direction, q.b);
        const Vec from = origin + direction * at - q.a;
        const float squared = dot(from, from);
        if (squared >= q.r0 * q.r0 && squared <= q.r1 * q.r1) t[0] = at;
    } else {
        const Vec along = q.b - q.a;
        const float length = std::sqrt(dot(along, along));
        const Vec axis = along * (1 / length);
        const float slope = (q.r1 - q.r0) / length;
        const Vec from = origin - q.a;
        const float h = dot(from, axis), rise = dot(direction, axis);
        const Vec across = from - axis * h, run = direction - axis * rise;
        const float r = q.r0 + slope * h;
        const float a = dot(run, run) - slope * slope * rise * rise;
        const float half_b = dot(run, across) - slope * rise * r;
        const float c = dot(across, across) - r * r;
        const float root = std::sqrt(half_b * half_b - a * c);
        const float sum = -(half_b + std::copysign(root, half_b));
        const float both[2] = {c / sum, sum / a};
        for (int k = 0; k < 2; k++) {
            const float height = h + both[k] * rise;
            if (height >= 0 && height <= length) t[k] = both[k];
        }
    }
}

static void intersect(const RTCIntersectFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto* query = reinterpret_cast<RTCRayHit*>(args->rayhit);
    RTCRay& ray = query->ray;
    const Quadric& q = static_cast<const Quadric*>(args->geometryUserPtr)[args->primID];
    float t[2];
    roots(q, {ray.org_x, ray.org_y, ray.org_z}, {ray.dir_x, ray.dir_y, ray.dir_z}, t);
    for (float candidate : t) {
        if (candidate >= ray.tnear && candidate <= ray.tfar) {
            ray.tfar = candidate;
            query->hit.primID = args->primID;
            query->hit.geomID = args->geomID;
        }
    }
}

template <typename T>
static std::vector<T> read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    std::vector<T> items(bytes.size() / sizeof(T));
    std::copy(bytes.begin(), bytes.begin() + items.size() * sizeof(T), reinterpret_cast<char*>(items.data()));
    return items;
}

struct Ray {
    Vec origin, direction;
    float nearest;
};

static size_t trace(RTCScene scene, const std::vector<Ray>& rays) {
    size_t hits = 0;
    for (const Ray& r : rays) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        alignas(16) RTCRayHit query;
        query.ray = {r.origin.x, r.origin.y, r.origin.z, r.nearest, r.direction.x, r.direction.y, r.direction.z, 0,
                     INFINITY, ~0u, 0, 0};
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &query);
        hits += query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
}

int main(int argc, char** argv) {
    if (argc < 3) return std::fprintf(stderr, "usage: embree FOLDER SCENE:KIND,KIND...\n"), 2;
    const std::string folder = std::string(argv[1]) + "/";
    RTCDevice device = rtcNewDevice("threads=1");
    for (int i = 2; i < argc; i++) {
        const std::string argument = argv[i], name = argument.substr(0, argument.find(':'));
        auto triangles = read<float>(folder + name + ".triangles");
        auto quadrics = read<Quadric>(folder + name + ".quadrics");
        RTCScene scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
        if (!triangles.empty()) {
            RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
            const size_t n = triangles.size() / 9;
            auto* corners = static_cast<float*>(
                rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * n));
            std::copy(triangles.begin(), triangles.end(), corners);
            auto* index = static_cast<uint32_t*>(
                rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, n));
            for (uint32_t k = 0; k < 3 * n; k++) index[k] = k;
            rtcCommitGeometry(mesh);
            rtcAttachGeometry(scene, mesh);
        }
        if (!quadrics.empty()) {
            RTCGeometry user = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
            rtcSetGeometryUserPrimitiveCount(user, quadrics.size());
            rtcSetGeometryUserData(user, quadrics.data());
            rtcSetGeometryBoundsFunction(user, bounds, nullptr);
            rtcSetGeometryIntersectFunction(user, intersect);
            rtcCommitGeometry(user);
            rtcAttachGeometry(scene, user);
        }
        rtcCommitScene(scene);
        for (size_t at = argument.find(':'); at != std::string::npos;) {
            const size_t end = argument.find(',', at + 1);
            const std::string kind = argument.substr(at + 1, end == std::string::npos ? end : end - at - 1);
            const auto rays = read<Ray>(folder + name + "." + kind + ".rays");
            size_t hits = 0;
            double best = INFINITY;
            for (int repeat = 0; repeat < 20; repeat++) {
                const auto begin = std::chrono::steady_clock::now();
                hits = trace(scene, rays);
                best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
            }
            std::printf("%s %s %.0f %zu\n", name.c_str(), kind.c_str(), rays.size() / best, hits);
            at = end;
        }
        rtcReleaseScene(scene);
    }
    rtcReleaseDevice(device);
}
