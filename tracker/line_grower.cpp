#include "tracker/line_grower.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "tracker/line_fade.hpp"
#include "tracker/line_look.hpp"
#include "tracker/line_paths.hpp"
#include "tracker/paired_points.hpp"

namespace atropos::tracker {
namespace {

using Eigen::Vector2d;
using Nodes = std::vector<LineNode>;

constexpr int kWindow = 8, kLeastSeen = 5;  // nodes, and how many of them must be seen

double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

void turn(Nodes& line) {
    std::reverse(line.begin(), line.end());
    for (LineNode& node : line)
        for (RidgePoint& point : node.eye) point.tangent = -point.tangent;
}

int seen_of_last(const Nodes& line) {
    return static_cast<int>(std::count_if(line.end() - std::min<std::ptrdiff_t>(std::ssize(line), kWindow),
                                          line.end(), [](const LineNode& node) { return node.both(); }));
}

/// Whether a line comes back to lie along itself: crossings, it may have.
bool runs_along(const Nodes& line, const LineNode& node) {
    constexpr double kBeside_px = 3.0, kAlike = 0.9;
    constexpr std::ptrdiff_t kApart = 28;  // nodes
    return std::any_of(line.begin(), line.end() - std::min(kApart, std::ssize(line)), [&](const LineNode& n) {
        return (n.eye[0].px - node.eye[0].px).norm() < kBeside_px &&
               std::abs(n.eye[0].tangent.dot(node.eye[0].tangent)) > kAlike;
    });
}

class Grower {
  public:
    Grower(const RectifiedView& view, const std::array<EyeLines, 2>& eyes, double row_offset_px,
           const LineGrowerOptions& options)
        : view_(view), eyes_(eyes), row_offset_px_(row_offset_px), options_(options) {}

    /// Both paths run the same way.
    std::array<LineEnd, 2> run(std::array<ImagePath, 2>& paths, scenes::ThreadPolarity polarity) {
        for (const std::size_t eye : {0, 1}) looks_[eye] = LineLook(eyes_[eye].image, paths[eye], polarity);
        const Nodes found = nodes_of(paths);
        std::array<LineEnd, 2> ends{LineEnd::kPlain, LineEnd::kPlain};
        if (found.size() < 20 || usual_[0] <= 0.0 || usual_[1] <= 0.0) return ends;
        const std::ptrdiff_t size = std::min<std::ptrdiff_t>(std::ssize(found), 40);
        const auto begin = found.begin() + surest(found, size), end = begin + size;
        Nodes line(begin, end), before(found.begin(), begin);
        for (LineNode& node : line)
            for (const std::size_t eye : {0, 1})
                node.clutter[eye] = looks_[eye].beside(node.eye[eye], options_.search_px);
        ends[1] = follow(line, {end, found.end()});
        trim(line, ends[1]);
        turn(line);
        turn(before);
        ends[0] = follow(line, before);
        trim(line, ends[0]);
        turn(line);
        write_paths(line, ends, eyes_, paths);
        return ends;
    }

  private:
    /// The pairs of both paths, and the contrast they have.
    Nodes nodes_of(const std::array<ImagePath, 2>& paths) {
        const RectifiedPath left = view_.path(paths[0], 0, options_.step_px);
        const RectifiedPath right = view_.path(paths[1], 1, 0.5);
        const Pairing pairing = pair_paths(view_, left, right, row_offset_px_, false, {});
        const std::array<std::vector<double>, 2> arc{paths[0].arc_lengths_px(), paths[1].arc_lengths_px()};
        Nodes line;
        for (const PairedPoint& pair :
             paired_points(view_, left, right, pairing, false, row_offset_px_, {})) {
            if (pair.arc_px[0] < 0.0 || pair.arc_px[1] < 0.0) continue;
            LineNode node;
            node.arc_px = pair.arc_px;
            for (const std::size_t eye : {0, 1}) {
                const auto i =
                    std::lower_bound(arc[eye].begin(), arc[eye].end(), pair.arc_px[eye]) - arc[eye].begin();
                node.eye[eye] =
                    paths[eye].points[static_cast<std::size_t>(std::min(i, std::ssize(arc[eye]) - 1))];
                node.contrast[eye] = looks_[eye].at(node.eye[eye], 1.0).contrast;
            }
            node.left = view_.rectified(node.eye[0].px, 0);
            node.disparity_px = view_.disparity_of(pair.p_C);
            line.push_back(node);
        }
        for (const std::size_t eye : {0, 1}) {
            std::vector<double> contrasts, strengths;
            for (const LineNode& node : line) {
                if (node.eye[eye].strength_levels <= 0.0) continue;
                contrasts.push_back(node.contrast[eye]);
                strengths.push_back(node.eye[eye].strength_levels);
            }
            usual_[eye] = median(std::move(contrasts));
            strength_[eye] = median(std::move(strengths));
            for (LineNode& node : line)
                node.seen[eye] = node.contrast[eye] > options_.least_contrast * usual_[eye];
        }
        return line;
    }

    /// Of the usual contrast, in the eye that sees less; more than usual is not more certain.
    double share(const LineNode& node) const {
        return std::min({node.contrast[0] / usual_[0], node.contrast[1] / usual_[1], 1.0});
    }

    /// Where the stretch of `size` nodes with most contrast begins.
    std::ptrdiff_t surest(const Nodes& line, std::ptrdiff_t size) const {
        std::ptrdiff_t best = 0;
        double most = -1.0;
        for (std::ptrdiff_t i = 0; i + size <= std::ssize(line); ++i) {
            double total = 0.0;
            for (std::ptrdiff_t k = i; k < i + size; ++k) total += share(line[static_cast<std::size_t>(k)]);
            if (total <= most) continue;
            most = total;
            best = i;
        }
        return best;
    }

    /// Lengthens the line at its back; `found` is what the paths have beyond.
    LineEnd follow(Nodes& line, const Nodes& found) {
        while (true) {
            const LineEnd end = grow(line);
            if ((end != LineEnd::kPlain && end != LineEnd::kOneEye) || !resume(line, found)) return end;
        }
    }

    /// Goes on with the first stretch of what was found beyond the line's back that is the line as surely;
    /// what was grown beside it, is taken back.
    bool resume(Nodes& line, const Nodes& found) const {
        constexpr double kNear_px = 4.0;
        constexpr std::size_t kBack = 40, kSeed = 20;  // nodes
        for (std::size_t size = line.size(); size > kSeed && size + kBack > line.size(); --size) {
            const LineNode& back = line[size - 1];
            const auto off_px = [&](const LineNode& node) {
                return (node.eye[0].px - back.eye[0].px).norm() +
                       std::abs(node.disparity_px - back.disparity_px);
            };
            const auto here =
                std::min_element(found.begin(), found.end(),
                                 [&](const LineNode& a, const LineNode& b) { return off_px(a) < off_px(b); });
            if (here == found.end()) return false;
            if (off_px(*here) > kNear_px) continue;
            const auto end = sure_from(here + 1, found.end());
            if (end == found.end() || leaps({line.data(), size}, {here + 1, end + 1}, view_.focal_px()))
                return false;
            line.resize(size);
            line.insert(line.end(), here + 1, end + 1);
            return true;
        }
        return false;
    }

    /// Takes off at the back what has so much less contrast than what comes before that it is something else:
    /// the line ends at half its contrast. Where it fades, nobody knows where that is.
    void trim(Nodes& line, LineEnd& end) const {
        constexpr double kHalf = 0.5, kLittle = 0.3, kMuch = 0.7, kSharp_px = 8.0, kOn_px = 7.0;
        if (end == LineEnd::kHidden) return;
        if (end == LineEnd::kLeaves) {
            const auto last = std::find_if(line.rbegin(), line.rend(),
                                           [&](const LineNode& node) { return has_ground(node); });
            const std::span<const LineNode> known(line.begin(), last.base());
            if (fainter_at_back(known, kHalf) == 0) return;
            line.resize(known.size());
            end = LineEnd::kPlain;
        }
        Nodes on = line;
        look_on(on);
        const auto px = [&](std::ptrdiff_t nodes) { return options_.step_px * static_cast<double>(nodes); };
        const double fade_px = px(fainter_at_back(on, kMuch) - fainter_at_back(on, kLittle));
        const double on_px = px(std::ssize(on) - std::ssize(line) - fainter_at_back(on, kHalf));
        line.resize(line.size() - static_cast<std::size_t>(fainter_at_back(line, kHalf)));
        if (end != LineEnd::kPlain) return;
        if (fade_px > kSharp_px || is_edge(std::span<const LineNode>(on).subspan(line.size())))
            end = LineEnd::kFades;
        else if (on_px > kOn_px)
            end = LineEnd::kOneEye;
    }

    /// Whether an edge of the ground runs along a stretch, in which a line would not be seen: one side darker
    /// than the other by more than the line is.
    bool is_edge(std::span<const LineNode> stretch) const {
        constexpr double kShare = 0.7;  // of the contrast it had
        for (const std::size_t eye : {0, 1}) {
            std::array<double, 2> level{};
            for (const LineNode& node : stretch) {
                const std::array<double, 2> sides = looks_[eye].sides(node.eye[eye]);
                level = {level[0] + sides[0], level[1] + sides[1]};
            }
            if (std::abs(level[0] - level[1]) > kShare * usual_[eye] * std::max(level[0], level[1]))
                return true;
        }
        return false;
    }

    /// Whether both eyes' images show what lies beside a node.
    bool has_ground(const LineNode& node) const {
        constexpr double kBeside_px = 9.0;
        for (const std::size_t eye : {0, 1})
            for (const double side : {-kBeside_px, kBeside_px}) {
                const RidgePoint& at = node.eye[eye];
                const Vector2d px = at.px + side * Vector2d(-at.tangent.y(), at.tangent.x());
                if (px.minCoeff() < 0.0 || px.x() > eyes_[eye].image.width - 1 ||
                    px.y() > eyes_[eye].image.height - 1)
                    return false;
            }
        return true;
    }

    /// Where it would go on, unseen.
    void look_on(Nodes& line) const {
        constexpr double kAhead_px = 15.0;
        for (int k = 0; k * options_.step_px < kAhead_px; ++k) {
            LineNode node = next(line, k * options_.step_px);
            if (leaves(node)) return;
            for (const std::size_t eye : {0, 1})
                node.contrast[eye] = looks_[eye].at(node.eye[eye], options_.search_px).contrast;
            line.push_back(node);
        }
    }

    /// The last node of the first stretch that is the line surely; the end when there is none.
    Nodes::const_iterator sure_from(Nodes::const_iterator begin, Nodes::const_iterator end) const {
        constexpr std::ptrdiff_t kStretch = 20, kLeast = 4;
        const std::ptrdiff_t stretch = std::min(kStretch, end - begin);
        if (stretch < kLeast) return end;
        double sum = 0.0;
        for (auto node = begin; node != end; ++node) {
            sum += share(*node);
            if (node - begin >= stretch) sum -= share(*(node - stretch));
            if (node - begin + 1 >= stretch && sum >= options_.sure_share * static_cast<double>(stretch))
                return node;
        }
        return end;
    }

    /// Follows the line until it is not seen for long, hidden, or out of the image.
    LineEnd grow(Nodes& line) {
        constexpr std::size_t kMost = 1000;  // nodes
        const std::size_t before = line.size();
        const auto steps = [&](double px) { return static_cast<std::size_t>(px / options_.step_px); };
        const std::size_t patience = steps(options_.longest_gap_px) + kWindow;
        std::size_t solid = before, along = 0;
        LineEnd end = LineEnd::kPlain;
        while (end == LineEnd::kPlain && line.size() < before + kMost && line.size() - solid <= patience) {
            LineNode node = next(line, static_cast<double>(line.size() - solid) * options_.step_px);
            if (!(node.disparity_px > 0.5)) break;
            end = leaves(node) ? LineEnd::kLeaves : is_hidden(node) ? LineEnd::kHidden : end;
            if (end != LineEnd::kPlain) break;
            measure(line, node);
            along = runs_along(line, node) ? along + 1 : 0;
            line.push_back(node);
            if (node.both() && seen_of_last(line) >= kLeastSeen) solid = line.size();
            if (along <= kWindow) continue;
            end = LineEnd::kItself;
            solid = std::min(solid, line.size() - along);
        }
        constexpr double kBridge_px = 12.0;
        if (end == LineEnd::kHidden || end == LineEnd::kLeaves) {
            if (line.size() - solid <= steps(kBridge_px)) return end;
            end = LineEnd::kPlain;
        }
        if (end == LineEnd::kPlain && one_eye_goes_on(line, solid)) end = LineEnd::kOneEye;
        line.resize(std::max<std::size_t>(solid, 1));
        return end;
    }

    static bool one_eye_goes_on(const Nodes& line, std::size_t from) {
        constexpr std::ptrdiff_t kAhead = 12, kMost = 8;  // nodes
        const auto begin = line.begin() + static_cast<std::ptrdiff_t>(from);
        return std::count_if(begin, begin + std::min(kAhead, line.end() - begin),
                             [](const LineNode& node) { return node.seen[0] != node.seen[1]; }) > kMost;
    }

    /// The line one step on, as it came, and where the eyes would see it.
    LineNode next(const Nodes& line, double unseen_px) const {
        const LineCourse course = course_of(line, unseen_px, options_.course);
        const double h = options_.step_px;
        LineNode node;
        node.left = course.ahead(h);
        node.disparity_px = course.disparity_px + h * course.slope;
        for (const std::size_t eye : {0, 1}) {
            const auto pixel = [&](double s) {
                const double shift = eye == 0 ? 0.0 : course.disparity_px + s * course.slope;
                const Vector2d at = course.ahead(s) - Vector2d(shift, eye == 0 ? 0.0 : -row_offset_px_);
                return view_.pixel(at, static_cast<int>(eye));
            };
            node.eye[eye].px = pixel(h);
            node.eye[eye].tangent = (pixel(h + 0.5) - pixel(h - 0.5)).normalized();
        }
        return node;
    }

    /// Looks for the line at a node, and moves the node to it where both eyes see it at one place in space.
    void measure(const Nodes& line, LineNode& node) const {
        constexpr double kAgree_px = 0.8;
        std::array<LineSight, 2> sight;
        for (const std::size_t eye : {0, 1}) {
            sight[eye] = looks_[eye].at(node.eye[eye], options_.search_px);
            node.contrast[eye] = sight[eye].contrast;
            node.clutter[eye] = looks_[eye].beside(node.eye[eye], options_.search_px);
            node.seen[eye] = sight[eye].contrast > least_contrast(line, node, eye);
        }
        if (!node.both()) return;
        const auto normal = [&](std::size_t eye) {
            return Vector2d(-node.eye[eye].tangent.y(), node.eye[eye].tangent.x());
        };
        const Vector2d shift = sight[0].offset_px * normal(0);
        // What the right eye is off by beyond that is disparity, as far as the line's direction shows it.
        const double rest = sight[1].offset_px - normal(1).dot(shift), by_disparity = -normal(1).x();
        if (std::abs(rest) > kAgree_px + known_disparity_px(line) * std::abs(by_disparity)) {
            node.seen = {};
            return;
        }
        node.left += shift;
        node.disparity_px += rest * by_disparity / (by_disparity * by_disparity + 1.0);
        for (const std::size_t eye : {0, 1}) {
            node.eye[eye].px += sight[eye].offset_px * normal(eye);
            node.eye[eye].strength_levels = strength_[eye];
        }
    }

    /// By what contrast the line had last, which changes slowly, and what lies beside it.
    double least_contrast(const Nodes& line, const LineNode& node, std::size_t eye) const {
        constexpr std::ptrdiff_t kBehind = 30, kBeside = 12;  // nodes
        constexpr double kHere = 0.3;
        std::vector<double> contrast;
        for (auto n = line.rbegin(); n != line.rend() && std::ssize(contrast) < kBehind; ++n)
            if (n->both()) contrast.push_back(n->contrast[eye]);
        double beside = 0.0;
        const std::ptrdiff_t count = std::min(kBeside, std::ssize(line));
        for (auto n = line.end() - count; n != line.end(); ++n) beside += n->clutter[eye];
        beside /= static_cast<double>(std::max<std::ptrdiff_t>(count, 1));
        const double had = std::max(median(std::move(contrast)), kHere * usual_[eye]);
        return std::max(options_.least_contrast * had,
                        options_.least_clutter * ((1.0 - kHere) * beside + kHere * node.clutter[eye]));
    }

    bool is_hidden(const LineNode& node) const {
        return index(node, 0) == RidgePointMap::kHidden || index(node, 1) == RidgePointMap::kHidden;
    }
    std::int32_t index(const LineNode& node, std::size_t eye) const {
        const Vector2d& px = node.eye[eye].px;
        return eyes_[eye].map.index(static_cast<int>(std::lround(px.x())),
                                    static_cast<int>(std::lround(px.y())));
    }

    bool leaves(const LineNode& node) const {
        constexpr double kMargin_px = 3.0;
        for (const std::size_t eye : {0, 1}) {
            const Vector2d& px = node.eye[eye].px;
            if (!px.allFinite() || px.minCoeff() < kMargin_px ||
                px.x() > eyes_[eye].image.width - 1 - kMargin_px ||
                px.y() > eyes_[eye].image.height - 1 - kMargin_px)
                return true;
        }
        return false;
    }

    const RectifiedView& view_;
    const std::array<EyeLines, 2>& eyes_;
    double row_offset_px_;
    LineGrowerOptions options_;
    std::array<LineLook, 2> looks_;
    std::array<double, 2> usual_{}, strength_{};  ///< contrast and strength of the paths, medians
};

}  // namespace

std::array<LineEnd, 2> grow_line(const RectifiedView& view, const std::array<EyeLines, 2>& eyes,
                                 scenes::ThreadPolarity polarity, bool turned, double row_offset_px,
                                 std::array<ImagePath, 2>& paths, const LineGrowerOptions& options) {
    if (turned) paths[1].reverse();
    const std::array<LineEnd, 2> ends = Grower(view, eyes, row_offset_px, options).run(paths, polarity);
    if (turned) paths[1].reverse();
    return ends;
}

}  // namespace atropos::tracker
