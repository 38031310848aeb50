#include "tracker/eye_sight.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

constexpr int kTurns = 4;                  ///< frames in which every cell looks once
constexpr double kPatchSigma_px = 0.04;    ///< that a patch is off by in every frame
constexpr double kLeastInformation = 2.0;  ///< 1/px^2; a patch that tells less says nothing
constexpr double kNearby_px = 3.0;         ///< of where a patch was found last
constexpr double kRobustSigmas = 1.5;      ///< Cauchy's scale

}  // namespace

EyeSight::EyeSight(const Options& options, const scenes::StereoRig& rig)
    : options_(options), rig_(rig), scale_(rig.left.width_px / 640.0) {
    reset();
}

void EyeSight::reset() {
    cells_.assign(kColumns * kRows, {});
    turn_ = 0;
    conclude();
}

void EyeSight::look(const std::array<ImageView, 2>& images, double dt_s) {
    const double keep = std::exp(-dt_s / options_.forget_s);
    for (Cell& cell : cells_) cell.information *= keep;
    for (std::size_t i = 0; i < cells_.size(); ++i)
        if (turn_ == 0 || static_cast<int>(i) % kTurns == turn_ % kTurns)
            look_in(images, static_cast<int>(i), cells_[i]);
    turn_ = turn_ % kTurns + 1;
    conclude();
}

EyeSight::OnLine EyeSight::on_line(const Eigen::Vector3d& ray_C, double nearness) const {
    const Eigen::Vector3d by_nearness = rig_.X_RC.translation();
    const Eigen::Vector3d p = rig_.X_RC.linear() * ray_C / ray_C.z() + nearness * by_nearness;
    Eigen::Matrix<double, 2, 3> J;
    OnLine place;
    place.px = rig_.right.project(p, J);
    place.by_nearness = J * by_nearness;
    place.by_roll = J * Eigen::Vector3d(-p.y(), p.x(), 0.0);
    return place;
}

// About the line of all depths, or about where the patch was.
cv::Rect EyeSight::region(const Eigen::Vector3d& ray_C, const Cell& cell) const {
    const bool known = cell.nearness > 0.0;
    const OnLine a = on_line(ray_C, known ? cell.nearness : 1.0 / options_.farthest_m);
    const OnLine b = known ? a : on_line(ray_C, 1.0 / options_.nearest_m);
    const Eigen::Vector2d by_eye(found_.correction.row_px, found_.correction.roll_rad);
    Eigen::Vector2d least = a.px.cwiseMin(b.px), most = a.px.cwiseMax(b.px);
    for (const OnLine& end : {a, b}) {
        const Eigen::Vector2d moved = end.px + by_eye[0] * Eigen::Vector2d::UnitY() + by_eye[1] * end.by_roll;
        least = least.cwiseMin(moved);
        most = most.cwiseMax(moved);
        const Eigen::Vector2d j(1.0, end.by_roll.y());
        const double beside =
            known ? kNearby_px : 1.0 + 3.0 * std::sqrt(std::max(0.0, j.dot(found_.covariance * j)));
        least = least.cwiseMin(moved - Eigen::Vector2d::Constant(beside));
        most = most.cwiseMax(moved + Eigen::Vector2d::Constant(beside));
    }
    const cv::Point low(static_cast<int>(std::floor(least.x())), static_cast<int>(std::floor(least.y())));
    const cv::Point high(static_cast<int>(std::ceil(most.x())), static_cast<int>(std::ceil(most.y())));
    return {low, high + cv::Point(1, 1)};
}

void EyeSight::look_in(const std::array<ImageView, 2>& images, int index, Cell& cell) {
    const int column = index % kColumns, row = index / kColumns;
    const int width = images[0].width, height = images[0].height;
    const cv::Point corner(column * width / kColumns, row * height / kRows);
    const cv::Point after((column + 1) * width / kColumns, (row + 1) * height / kRows);
    const auto place = matcher_.choose(images[0], {corner, after});
    if (!place) return;
    const Eigen::Vector3d ray_C =
        rig_.left.ray({static_cast<double>(place->x), static_cast<double>(place->y)});
    const auto match = matcher_.find(images[1], region(ray_C, cell));
    if (!match) {
        cell.nearness = 0.0;  // next time along the whole line
        return;
    }
    // The place of the line that is nearest; the line is all but straight in nearness.
    const Eigen::Vector2d by_eye(found_.correction.row_px, found_.correction.roll_rad);
    double nearness = cell.nearness > 0.0 ? cell.nearness : 1.0 / options_.farthest_m;
    OnLine at{};
    for (int i = 0; i < 4; ++i) {
        at = on_line(ray_C, nearness);
        const Eigen::Vector2d moved = at.px + by_eye[0] * Eigen::Vector2d::UnitY() + by_eye[1] * at.by_roll;
        nearness += at.by_nearness.dot(match->right_px - moved) / at.by_nearness.squaredNorm();
    }
    if (!(nearness > 0.0)) return;
    const Eigen::Vector2d along = at.by_nearness.normalized();
    const Eigen::Vector2d normal(-along.y(), along.x());
    cell.nearness = nearness;
    // Its place along the line is unknown.
    const Eigen::Matrix2d& I = match->information;
    const double mixed = normal.dot(I * along), along_line = along.dot(I * along);
    if (!(along_line > 0.0)) return;
    const double information = normal.dot(I * normal) - mixed * mixed / along_line;
    if (!(information > kLeastInformation)) return;
    const double share = information / (cell.information + information);
    cell.off_px += share * (normal.dot(match->right_px - at.px) - cell.off_px);
    cell.by_eye += share * (Eigen::Vector2d(normal.y(), normal.dot(at.by_roll)) - cell.by_eye);
    cell.information += information;
}

// Row and roll that most cells agree on (Cauchy, iteratively reweighted, from afar to near). Of such an
// estimate the covariance is that of least squares times E psi^2 / (E psi')^2 (Huber 1964): it grows as cells
// disagree.
void EyeSight::conclude() {
    const Eigen::Vector2d prior_sigma(options_.row_sigma_px * scale_, options_.roll_sigma_rad);
    const Eigen::Matrix2d prior = prior_sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    constexpr double kC2 = kRobustSigmas * kRobustSigmas;
    Eigen::Vector2d x = Eigen::Vector2d::Zero();
    Eigen::Matrix2d all = Eigen::Matrix2d::Zero();  // information, if all cells were right
    double squares = 0.0, slopes = 0.0, count = 0.0;
    for (const double widen_px : {2.0, 1.0, 0.5, 0.25, 0.1, 0.0, 0.0, 0.0}) {
        Eigen::Matrix2d H = prior;
        Eigen::Vector2d pull = -prior * x;
        all.setZero();
        squares = slopes = count = 0.0;
        for (const Cell& cell : cells_) {
            if (!(cell.information > 0.0)) continue;
            const double r = cell.off_px - cell.by_eye.dot(x);
            const double sigma2 = (kPatchSigma_px * kPatchSigma_px + widen_px * widen_px) * scale_ * scale_ +
                                  1.0 / cell.information;
            const double z2 = r * r / sigma2, share = 1.0 / (1.0 + z2 / kC2);
            const Eigen::Matrix2d information = cell.by_eye * cell.by_eye.transpose() / sigma2;
            H += share * information;
            pull += share / sigma2 * r * cell.by_eye;
            all += information;
            squares += share * share * z2;
            slopes += share * share * (1.0 - z2 / kC2);
            count += 1.0;
        }
        x += H.inverse() * pull;
    }
    found_.correction = {x[0], x[1]};
    // Two of the residuals are the fit's own.
    const double worse = count > 3.0 && slopes > 0.0
                             ? std::max(1.0, squares * count / (slopes * slopes) * count / (count - 2.0))
                             : 1.0;
    found_.covariance = (all / worse + prior).inverse();
}

double* EyeSight::save(double* out) const {
    *out++ = turn_;
    for (const Cell& cell : cells_)
        for (const double value :
             {cell.information, cell.off_px, cell.by_eye[0], cell.by_eye[1], cell.nearness})
            *out++ = value;
    return out;
}

const double* EyeSight::load(const double* in) {
    turn_ = static_cast<int>(*in++);
    for (Cell& cell : cells_) {
        cell = {in[0], in[1], {in[2], in[3]}, in[4]};
        in += 5;
    }
    conclude();
    return in;
}

}  // namespace atropos::tracker
