#include "tests/bench/mujoco_peer.hpp"

#include <dlfcn.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace atropos::experiments {
namespace {

using Eigen::Vector3d, Eigen::Vector3f;
namespace fs = std::filesystem;

constexpr float kNear_m = 0.005f, kFar_m = 1.0f;

// MuJoCo wants bodies: the tissue's rim is joined to a point below it, which no camera sees.
scenes::TriangleMesh closed(scenes::TriangleMesh mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    const auto apex = static_cast<std::uint32_t>(mesh.vertices.size());
    bool is_open = false;
    for (const auto& [edge, count] : edges) {
        if (edges.contains({edge.second, edge.first})) continue;
        mesh.triangles.push_back({edge.second, edge.first, apex});
        is_open = true;
    }
    if (is_open) mesh.vertices.emplace_back(0.0f, 0.0f, -0.05f);
    return mesh;
}

void write_stl(const fs::path& path, const scenes::TriangleMesh& mesh) {
    std::ofstream file(path, std::ios::binary);
    const auto put = [&](const auto& value) {
        file.write(reinterpret_cast<const char*>(&value), sizeof value);
    };
    file << std::string(80, ' ');
    put(static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
        put(std::array<float, 3>{});
        for (const auto i : t)
            put(std::array{mesh.vertices[i].x(), mesh.vertices[i].y(), mesh.vertices[i].z()});
        put(std::uint16_t{0});
    }
}

mjModel* model_of(std::span<const scenes::RenderItem> items, int width_px, int height_px) {
    std::string folder = (fs::temp_directory_path() / "atropos_peer_XXXXXX").string();
    if (!mkdtemp(folder.data())) throw std::runtime_error("no temporary folder");
    std::ostringstream assets, geoms;
    for (std::size_t i = 0; i < items.size(); ++i) {
        const scenes::RenderItem& item = items[i];
        write_stl(fs::path(folder) / (std::to_string(i) + ".stl"), closed(*item.mesh));
        assets << "<mesh name='m" << i << "' file='" << i << ".stl'/>";
        const Vector3d p = item.X_WM.translation();
        const Eigen::Quaterniond q(item.X_WM.linear());
        const Vector3f c =
            item.label == scenes::Label::kTissue ? Vector3f(0.6f, 0.26f, 0.21f) : item.material.base_colour;
        geoms << "<geom type='mesh' mesh='m" << i << "' contype='0' conaffinity='0' pos='" << p.transpose()
              << "' quat='" << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << "' rgba='"
              << c.transpose() << " 1'/>";
    }
    const fs::path file = fs::path(folder) / "scene.xml";
    std::ofstream(file) << "<mujoco><compiler meshdir='" << folder << "'/><visual><global offwidth='"
                        << 2 * width_px << "' offheight='" << height_px
                        << "'/><quality offsamples='0'/></visual><asset>" << assets.str()
                        << "</asset><worldbody>" << geoms.str() << "</worldbody></mujoco>";
    std::array<char, 500> error{};
    mjModel* model = mj_loadXML(file.c_str(), nullptr, error.data(), error.size());
    fs::remove_all(folder);
    if (!model) throw std::runtime_error(std::string("MuJoCo: ") + error.data());
    return model;
}

mjvGLCamera gl_camera(const scenes::Camera& c, const Eigen::Isometry3d& X_WE) {
    mjvGLCamera gl{};
    const Vector3d forward = X_WE.linear().col(2), up = -X_WE.linear().col(1);
    for (int k = 0; k < 3; ++k) {
        gl.pos[k] = static_cast<float>(X_WE.translation()[k]);
        gl.forward[k] = static_cast<float>(forward[k]);
        gl.up[k] = static_cast<float>(up[k]);
    }
    gl.frustum_near = kNear_m;
    gl.frustum_far = kFar_m;
    gl.frustum_top = static_cast<float>(kNear_m * (c.cy_px + 0.5) / c.fy_px);
    gl.frustum_bottom = static_cast<float>(-kNear_m * (c.height_px - c.cy_px - 0.5) / c.fy_px);
    gl.frustum_center = static_cast<float>(kNear_m * (0.5 * c.width_px - c.cx_px - 0.5) / c.fx_px);
    return gl;
}

}  // namespace

struct MujocoPeer::Impl {
    using Context = struct osmesa_context*;

    Impl(std::span<const scenes::RenderItem> items, const scenes::StereoRig& rig,
         const Eigen::Isometry3d& X_WC)
        : viewport{0, 0, 2 * rig.left.width_px, rig.left.height_px},
          window(4 * pixels()),
          colour(3 * pixels()),
          depth(pixels()) {
        setenv("LP_NUM_THREADS", "0", 0);
        void* library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_GLOBAL);  // where MuJoCo looks for it
        if (!library) throw std::runtime_error("no libOSMesa.so.8");
        make_current = reinterpret_cast<decltype(make_current)>(dlsym(library, "OSMesaMakeCurrent"));
        const auto create = reinterpret_cast<Context (*)(unsigned, int, int, int, Context)>(
            dlsym(library, "OSMesaCreateContextExt"));
        context = create(0x1908, 24, 8, 0, nullptr);  // OSMESA_RGBA
        bind();
        model = model_of(items, rig.left.width_px, rig.left.height_px);
        data = mj_makeData(model);
        mj_forward(model, data);
        mjv_defaultOption(&options);
        mjv_defaultCamera(&camera);
        mjv_defaultScene(&scene);
        mjr_defaultContext(&renderer);
        mjv_makeScene(model, &scene, static_cast<int>(items.size()) + 10);
        mjr_makeContext(model, &renderer, mjFONTSCALE_100);
        mjr_setBuffer(mjFB_OFFSCREEN, &renderer);
        scene.flags[mjRND_SHADOW] = scene.flags[mjRND_REFLECTION] = scene.flags[mjRND_SKYBOX] = 0;
        scene.stereo = mjSTEREO_SIDEBYSIDE;
        eyes = {gl_camera(rig.left, X_WC), gl_camera(rig.right, X_WC * rig.X_RC.inverse())};
    }

    ~Impl() {
        bind();
        mjr_freeContext(&renderer);
        mjv_freeScene(&scene);
        mj_deleteData(data);
        mj_deleteModel(model);
        make_current(nullptr, nullptr, 0, 0, 0);
    }

    void bind() { make_current(context, window.data(), 0x1401, viewport.width, viewport.height); }

    std::size_t pixels() const {
        return static_cast<std::size_t>(viewport.width) * static_cast<std::size_t>(viewport.height);
    }

    mjrRect viewport;
    std::vector<unsigned char> window, colour;
    std::vector<float> depth;
    Context context = nullptr;
    unsigned char (*make_current)(Context, void*, unsigned, int, int) = nullptr;
    mjModel* model = nullptr;
    mjData* data = nullptr;
    mjvOption options{};
    mjvCamera camera{};
    mjvScene scene{};
    mjrContext renderer{};
    std::array<mjvGLCamera, 2> eyes{};
};

MujocoPeer::MujocoPeer(std::span<const scenes::RenderItem> items, const scenes::StereoRig& rig,
                       const Eigen::Isometry3d& X_WC)
    : impl_(std::make_unique<Impl>(items, rig, X_WC)) {}

MujocoPeer::~MujocoPeer() = default;

void MujocoPeer::draw() {
    Impl& i = *impl_;
    i.bind();
    mjv_updateScene(i.model, i.data, &i.options, nullptr, &i.camera, mjCAT_ALL, &i.scene);
    std::copy(i.eyes.begin(), i.eyes.end(), i.scene.camera);
    mjr_render(i.viewport, &i.scene, &i.renderer);
    mjr_readPixels(i.colour.data(), i.depth.data(), i.viewport, &i.renderer);
    i.make_current(nullptr, nullptr, 0, 0, 0);
}

float MujocoPeer::depth_m(int eye, int x, int y) const {
    const Impl& i = *impl_;
    const int row = i.viewport.height - 1 - y, column = eye * (i.viewport.width / 2) + x;
    const float d = i.depth[static_cast<std::size_t>(row * i.viewport.width + column)];
    return kNear_m * kFar_m / (kFar_m - d * (kFar_m - kNear_m));
}

}  // namespace atropos::experiments
