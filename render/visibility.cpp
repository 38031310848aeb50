#include "render/visibility.hpp"

#include "render/thread_body.hpp"

namespace atropos::render {
namespace {

constexpr double kOwnNeighbourhood_radii = 6.0;

Visibility hidden_by(const scenes::RenderItem& item) {
    return item.at_rest || item.label == scenes::Label::kTissue ? Visibility::kBehindTissue
                                                                : Visibility::kBehindTool;
}

}  // namespace

const RayCaster& VisibilityTest::caster(const std::shared_ptr<const scenes::TriangleMesh>& mesh) {
    Entry& entry = casters_[mesh.get()];
    if (!entry.caster) {
        entry.mesh = mesh;
        entry.caster = std::make_unique<RayCaster>(*mesh);
    }
    entry.unused = 0;
    return *entry.caster;
}

void VisibilityTest::forget_meshes_unused_for(int frames) {
    for (auto entry = casters_.begin(); entry != casters_.end();) {
        entry = ++entry->second.unused > frames ? casters_.erase(entry) : std::next(entry);
    }
}

std::vector<SampleView> VisibilityTest::views(const FrameInput& input, const Eye& eye) {
    std::vector<SampleView> views(input.samples.size());
    if (views.empty()) return views;
    const Eigen::Isometry3d X_EW = eye.X_EC * input.X_WC.inverse();
    const Eigen::Vector3d p_eye = X_EW.inverse().translation();
    const double r2_max = monotonic_r2(eye.camera);
    std::vector<ThreadBody> bodies(input.ribbons.begin(), input.ribbons.end());
    std::vector<std::pair<const RayCaster*, Eigen::Isometry3d>> casters;
    for (const scenes::RenderItem& item : input.items)
        casters.emplace_back(&caster(item.mesh), item.X_WM.inverse());

    for (std::size_t i = 0; i < views.size(); ++i) {
        const SamplePoint& sample = input.samples[i];
        const Eigen::Vector3d p_E = X_EW * sample.p_W, ray = sample.p_W - p_eye;
        if (p_E.z() <= 0.0 || p_E.head<2>().squaredNorm() >= r2_max * p_E.z() * p_E.z()) continue;
        views[i].pixel = eye.camera.project(p_E);
        if (!eye.camera.contains(views[i].pixel)) continue;
        views[i].visibility = Visibility::kVisible;

        const bool on_thread = sample.ribbon >= 0 && static_cast<std::size_t>(sample.ribbon) < bodies.size();
        const double radius_m = on_thread ? bodies[static_cast<std::size_t>(sample.ribbon)].radius_m() : 0.0;
        double nearest = 1.0 - std::max(radius_m, 1e-6) / ray.norm();
        for (std::size_t k = 0; k < casters.size(); ++k) {
            const auto& [mesh, X_MW] = casters[k];
            const auto hit = mesh->cast(X_MW * p_eye, X_MW.linear() * ray, nearest);
            if (!hit) continue;
            nearest = *hit;
            views[i].visibility = hidden_by(input.items[k]);
        }
        if (views[i].visibility != Visibility::kVisible) continue;
        for (std::size_t k = 0; k < bodies.size(); ++k) {
            const bool own = on_thread && k == static_cast<std::size_t>(sample.ribbon);
            const double own_m = own ? kOwnNeighbourhood_radii * radius_m : -1.0;
            if (bodies[k].blocks(p_eye, sample.p_W, sample.s_m - own_m, sample.s_m + own_m)) {
                views[i].visibility = Visibility::kBehindThread;
            }
        }
    }
    return views;
}

}  // namespace atropos::render
