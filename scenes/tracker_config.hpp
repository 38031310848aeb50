#pragma once

#include <Eigen/Core>
#include <string>

namespace atropos::scenes {

/// Which tracker runs: the paper's first and second approximation (eq. 10, 15), or the continuous refinement.
enum class TrackerMethod { kE1, kE2, kRefined };

/// How the chain of labels is minimised (II-D3): exactly, or by iterated conditional modes as a comparison.
enum class LabelOptimiser { kDynamicProgramming, kIcm };

/// Unknowns of the paper's energies (II-B): 3K control points in space, or 4K in the two images.
enum class Parameterisation { k3d, k2d };

enum class ThreadPolarity { kDark, kBright, kEither };  ///< thread against what lies behind it

enum class ImageChannel { kGray, kRed, kGreen, kBlue };  ///< of colour images; gray ones have only themselves

enum class LabelPreset {
    kCustom,         ///< `s_m` as given
    kPaperTable1,    ///< r (s + s/2) reaches 14 px of a 640 px wide image ("s = 16")
    kPaperScissors,  ///< a quarter of it ("s = 4")
};

enum class LabelShape {
    kCube,  ///< the paper's: three axes of C and the four main diagonals of the cube
    kRays,  ///< the same directions in a frame along the node's viewing ray, longer in depth
};

/// Everything a tracker can be told, SI units. What the paper leaves open is argued in docs/method.md.
/// Figures "at 640" are pixels of a 640 px wide image; they grow with the width.
struct TrackerConfig {
    TrackerMethod method = TrackerMethod::kE2;
    LabelOptimiser optimiser = LabelOptimiser::kDynamicProgramming;
    Parameterisation parameterisation = Parameterisation::k3d;
    int threads = 1;  ///< worker threads; any number gives the same bytes

    struct Thread {
        double length_m = 0.0;         ///< span between the ends; 0 = unknown
        bool length_is_known = false;  ///< C'_ref of eq. 7 from `length_m` instead of the initial curve
        double width_m = 0.00035;      ///< diameter of the thread: sets the detector's scale
        ThreadPolarity polarity = ThreadPolarity::kDark;
        ImageChannel channel = ImageChannel::kGray;
    } thread;

    struct Curve {
        int control_points = 8;  ///< K (II-B)
        int degree = 3;          ///< d
        int samples = 60;        ///< midpoints along u at which the integrals are summed
    } curve;

    struct CostImage {
        int scales = 1;           ///< standard deviations of the Hessian, from the thread's width upwards
        double scale_step = 1.5;  ///< ratio between them
        double blobness = 0.5;    ///< Frangi's beta: tolerance to round structures
        double contrast_levels = 8.0;    ///< Frangi's c, grey levels of scale-normalised curvature
        double threshold = 0.5;          ///< of the measure in [0, 1]
        double truncation_px = 15.0;     ///< of the distance transform, at 640
        bool region_of_interest = true;  ///< only around the last curve
    } cost_image;

    struct Labels {
        int r = 3;  ///< labels on each side of each direction: 14 r + 1 in all
        LabelPreset preset = LabelPreset::kCustom;
        double s_m = 0.0008;  ///< spacing along an axis in the first step (custom)
        LabelShape shape = LabelShape::kCube;
        double depth_factor = 4.0;  ///< rays only: spacing along the ray over spacing across it
        int steps = 2;              ///< optimisation steps a frame, with s, s/2, ...
    } labels;

    /// Weights; data cost is in px at 640.
    double lambda1_e1 = 300.0;       ///< length, eq. 10
    double lambda2_e1_per_m = 10.0;  ///< |l_p - l_q|, eq. 10, px at 640 per m
    double lambda1_e2 = 30.0;        ///< length, eq. 15
    double lambda_stereo = 1.0;      ///< 2D parameterisation: squared epipolar distance, per px at 640

    struct Tips {
        double epsilon_m = 0.0001;      ///< free distance, eq. 19
        double weight_per_m = 20000.0;  ///< px at 640 per m
    } tips;

    /// One standard deviation of the curves of E1 and E2, at 640; 0 = the method's own, measured on the
    /// paper's camera (docs/method.md). Another camera wants its own.
    struct Uncertainty {
        double lateral_px = 0.0;    ///< across the viewing ray
        double disparity_px = 0.0;  ///< along it
    } uncertainty;

    /// The continuous refinement (method kRefined); shares `thread`, `labels` and `cost_image` with the
    /// paper's methods, which find the curve again when it is lost.
    struct Refined {
        int control_points = 0;          ///< 0: as many as length and bends need
        int samples = 80;                ///< places along the curve that are measured in each eye
        double search_px = 12.0;         ///< across the predicted curve, at 640
        double contrast_levels = 4.0;    ///< grey levels a thread is darker than both of its sides, at least
        double blur_px = 0.65;           ///< standard deviation of optics and pixel
        double length_sigma_m = 0.0002;  ///< of a known `thread.length_m`
        double tip_sigma_m = 0.0003;     ///< of measured ends, what is new in each frame
        double tip_bias_sigma_m = 0.0011;    ///< of measured ends, each axis: the arm's constant error
        double instrument_sigma_m = 0.0007;  ///< of measured instruments: they are taken for two sigma larger
        double row_sigma_px = 0.0;           ///< of the right eye's rows in a calibration that is off, at 640
        int coasting_frames = 30;            ///< unseen for longer: lost
        bool recovery = true;                ///< discrete search after a failed loss test
        std::string prior_file;              ///< of `atropos learn-prior`; empty: none
        double prior_weight = 1.0;           ///< of that prior; 0 = as without
        bool rod = false;                    ///< predicts by an inextensible rod whose ends are carried along
        Eigen::Vector3d gravity_C = Eigen::Vector3d::Zero();  ///< direction; the rod's; zero = unknown
    } refined;
};

}  // namespace atropos::scenes
