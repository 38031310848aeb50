#include "tests/bench/centre_line.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <opencv2/imgproc.hpp>

namespace atropos::bench {
namespace {

constexpr std::array<std::array<int, 2>, 8> kAround = {
    {{0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}}};

void thin(cv::Mat1b& mask) {
    bool changed = true;
    while (changed) {
        changed = false;
        for (const int pass : {0, 1}) {
            std::vector<cv::Point> remove;
            for (int v = 1; v + 1 < mask.rows; ++v)
                for (int u = 1; u + 1 < mask.cols; ++u) {
                    if (!mask(v, u)) continue;
                    std::array<int, 8> p{};
                    for (std::size_t k = 0; k < 8; ++k)
                        p[k] = mask(v + kAround[k][1], u + kAround[k][0]) ? 1 : 0;
                    int neighbours = 0, rises = 0;
                    for (std::size_t k = 0; k < 8; ++k) {
                        neighbours += p[k];
                        if (!p[k] && p[(k + 1) % 8]) ++rises;
                    }
                    if (neighbours < 2 || neighbours > 6 || rises != 1) continue;
                    const bool keep = pass == 0 ? (p[0] && p[2] && p[4]) || (p[2] && p[4] && p[6])
                                                : (p[0] && p[2] && p[6]) || (p[0] && p[4] && p[6]);
                    if (!keep) remove.emplace_back(u, v);
                }
            for (const cv::Point& p : remove) mask(p) = 0;
            changed = changed || !remove.empty();
        }
    }
}

/// Farthest pixel from `start` along the thinned line, and the way there.
std::vector<cv::Point> farthest_way(const cv::Mat1b& line, const cv::Point& start, cv::Mat1b& reached) {
    cv::Mat1i from(line.size(), -1);
    std::deque<cv::Point> queue{start};
    from(start) = 8;
    cv::Point last = start;
    while (!queue.empty()) {
        last = queue.front();
        queue.pop_front();
        reached(last) = 255;
        for (int k = 0; k < 8; ++k) {
            const auto& d = kAround[static_cast<std::size_t>(k)];
            const cv::Point to(last.x + d[0], last.y + d[1]);
            if (to.x < 0 || to.y < 0 || to.x >= line.cols || to.y >= line.rows || !line(to) || from(to) >= 0)
                continue;
            from(to) = k;
            queue.push_back(to);
        }
    }
    std::vector<cv::Point> way;
    for (cv::Point p = last;;) {
        way.push_back(p);
        const int k = from(p);
        if (k == 8) return way;
        p -= cv::Point(kAround[static_cast<std::size_t>(k)][0], kAround[static_cast<std::size_t>(k)][1]);
    }
}

}  // namespace

CentreLine centre_line(const cv::Mat1b& mask) {
    // With a margin, so that lines reach the image's border.
    constexpr int kMargin = 8;
    cv::Mat1b grown;
    cv::copyMakeBorder(mask, grown, kMargin, kMargin, kMargin, kMargin, cv::BORDER_REPLICATE);
    cv::Mat1b line = grown.clone();
    thin(line);
    cv::Mat1b seen(line.size(), 0);
    std::vector<cv::Point> best;
    for (int v = 0; v < line.rows; ++v)
        for (int u = 0; u < line.cols; ++u) {
            if (!line(v, u) || seen(v, u)) continue;
            cv::Mat1b ignored(line.size(), 0);
            const std::vector<cv::Point> way =
                farthest_way(line, farthest_way(line, {u, v}, seen).front(), ignored);
            if (way.size() > best.size()) best = way;
        }
    CentreLine result;
    const int n = static_cast<int>(best.size());
    for (int i = 0; i < n; ++i) {
        const int half = std::min({2, i, n - 1 - i});
        Eigen::Vector2d p = Eigen::Vector2d::Zero();
        for (int k = i - half; k <= i + half; ++k)
            p += Eigen::Vector2d(best[static_cast<std::size_t>(k)].x, best[static_cast<std::size_t>(k)].y);
        p = p / (2 * half + 1) - Eigen::Vector2d::Constant(kMargin);
        if (p.x() < 0.0 || p.y() < 0.0 || p.x() > mask.cols - 1 || p.y() > mask.rows - 1) continue;
        result.points.push_back(p);
    }
    // Width: the stroke's area by the line's length, each pixel counted at the nearest point of the line.
    result.width_px.assign(result.points.size(), 0.0);
    for (int v = 0; v < mask.rows; ++v)
        for (int u = 0; u < mask.cols; ++u) {
            if (!mask(v, u)) continue;
            double least = 12.0;
            std::size_t nearest = result.points.size();
            for (std::size_t i = 0; i < result.points.size(); ++i) {
                const double d = (result.points[i] - Eigen::Vector2d(u, v)).norm();
                if (d >= least) continue;
                least = d;
                nearest = i;
            }
            if (nearest < result.points.size()) result.width_px[nearest] += 1.0;
        }
    const std::vector<double> area = result.width_px;
    for (std::size_t i = 0; i < area.size(); ++i) {
        const std::size_t from = i < 7 ? 0 : i - 7, to = std::min(area.size() - 1, i + 7);
        double pixels = 0.0, length = 0.0;
        for (std::size_t k = from; k <= to; ++k) {
            pixels += area[k];
            if (k > from) length += (result.points[k] - result.points[k - 1]).norm();
        }
        result.width_px[i] = pixels / std::max(length + 1.0, 1.0);
    }
    return result;
}

namespace {

/// Number of points at an end that belong to a needle: up to the last place that is more than 5 px wide. A
/// needle's point is thin: it may lie before the first of them, within 60 points of the end.
int needle_points(const CentreLine& line, bool front) {
    const int n = static_cast<int>(line.points.size());
    int cut = 0;
    for (int i = 7; i < n; ++i) {
        if (line.width_px[static_cast<std::size_t>(front ? i : n - 1 - i)] > 5.0)
            cut = i + 1;
        else if (i > std::max(60, cut + 15))
            break;
    }
    return cut;
}

}  // namespace

CentreLine stroke_on_white(const cv::Mat& picture) {
    cv::Mat gray = picture;
    if (picture.channels() == 3) cv::cvtColor(picture, gray, cv::COLOR_BGR2GRAY);
    cv::Mat1b mask(gray <= 250);
    cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::Mat1b::ones(3, 3));
    return centre_line(mask);
}

void leave_needles_out(CentreLine& left, CentreLine& right) {
    // The same way along the thread in both eyes.
    const auto apart = [&](const Eigen::Vector2d& p) {
        return (left.points.front() - left.points.back()).dot(p);
    };
    if (apart(right.points.front() - right.points.back()) < 0.0) {
        std::reverse(right.points.begin(), right.points.end());
        std::reverse(right.width_px.begin(), right.width_px.end());
    }
    CentreLine* eyes[2] = {&left, &right};
    for (const bool front : {true, false}) {
        int cut[2] = {needle_points(left, front), needle_points(right, front)};
        for (int eye = 0; eye < 2; ++eye) {
            if (cut[eye] > 0 || cut[1 - eye] == 0) continue;
            // The needle that the other eye sees, up to the same row: the nearest to the same way from the
            // end.
            const auto& other = *eyes[1 - eye];
            const auto& mine = *eyes[eye];
            const auto at = [front](const CentreLine& line, int i) -> const Eigen::Vector2d& {
                return line.points[front ? static_cast<std::size_t>(i)
                                         : line.points.size() - 1 - static_cast<std::size_t>(i)];
            };
            const double row = at(other, cut[1 - eye]).y();
            double least = 1e9;
            for (int i = cut[1 - eye] / 2; i < 2 * cut[1 - eye]; ++i) {
                const double off = std::abs(at(mine, i).y() - row) + 0.05 * std::abs(i - cut[1 - eye]);
                if (off >= least) continue;
                least = off;
                cut[eye] = i;
            }
        }
        for (int eye = 0; eye < 2; ++eye) {
            CentreLine& line = *eyes[eye];
            if (front) {
                line.points.erase(line.points.begin(), line.points.begin() + cut[eye]);
                line.width_px.erase(line.width_px.begin(), line.width_px.begin() + cut[eye]);
            } else {
                line.points.resize(line.points.size() - static_cast<std::size_t>(cut[eye]));
                line.width_px.resize(line.points.size());
            }
        }
    }
}

}  // namespace atropos::bench
