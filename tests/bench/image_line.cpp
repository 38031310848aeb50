#include "tests/bench/image_line.hpp"

#include <algorithm>
#include <limits>

namespace atropos::bench {

double distance_px(const ImageLine& line, const Eigen::Vector2d& p) {
    double least = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const Eigen::Vector2d d = line[i + 1] - line[i];
        const double t = std::clamp((p - line[i]).dot(d) / std::max(d.squaredNorm(), 1e-12), 0.0, 1.0);
        least = std::min(least, (p - line[i] - t * d).norm());
    }
    return least;
}

double mean_distance_px(const ImageLine& from, const ImageLine& to) {
    double sum = 0.0;
    for (const Eigen::Vector2d& p : from) sum += distance_px(to, p);
    return from.empty() ? 0.0 : sum / static_cast<double>(from.size());
}

double frechet_px(const ImageLine& a, const ImageLine& b) {
    std::vector<double> row(b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        double diagonal = 0.0;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const double d = (a[i] - b[j]).norm(), above = row[j];
            const double reach = i == 0 && j == 0 ? 0.0
                                 : i == 0         ? row[j - 1]
                                 : j == 0         ? above
                                                  : std::min({above, diagonal, row[j - 1]});
            row[j] = std::max(d, reach);
            diagonal = above;
        }
    }
    return row.back();
}

int self_crossings(const ImageLine& line) {
    const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
        return a.x() * b.y() - a.y() * b.x();
    };
    int count = 0;
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
        for (std::size_t k = i + 2; k + 1 < line.size(); ++k) {
            const Eigen::Vector2d d = line[i + 1] - line[i], e = line[k + 1] - line[k];
            if (cross(d, line[k] - line[i]) * cross(d, line[k + 1] - line[i]) < 0.0 &&
                cross(e, line[i] - line[k]) * cross(e, line[i + 1] - line[k]) < 0.0)
                ++count;
        }
    return count;
}

}  // namespace atropos::bench
