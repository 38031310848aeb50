#include "tracker/cost_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "scenes/random_stream.hpp"
#include "tests/support/scalar_cost_image.hpp"
#include "tests/support/synthetic_sequence.hpp"
#include "tracker/eye.hpp"

namespace atropos::tracker {
namespace {

RC_GTEST_PROP(DistanceTransform, equals_the_nearest_ridge_pixel_by_brute_force, (std::uint64_t seed)) {
    scenes::RandomStream random(seed, "mask");
    const int width = 1 + static_cast<int>(random.integer(70));
    const int height = 1 + static_cast<int>(random.integer(40));
    const int truncation = 1 + static_cast<int>(random.integer(50));
    const double density = std::pow(10.0, random.uniform(-3.5, -0.3));
    std::vector<std::uint8_t> mask(static_cast<std::size_t>(width * height));
    for (std::uint8_t& m : mask) m = random.uniform() < density ? 255 : 0;
    std::vector<std::uint16_t> squared(mask.size());
    DistanceTransform().apply(mask.data(), width, width, height, truncation, {0, 0, width, height},
                              squared.data(), width);
    const cv::Mat1w plain =
        support::scalar_squared_distance(cv::Mat1b(height, width, mask.data()), truncation);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            RC_ASSERT(squared[static_cast<std::size_t>(y * width + x)] == plain(y, x));
}

cv::Mat1b noise_with_line(int width, int height) {
    scenes::RandomStream random(4, "picture");
    cv::Mat1b image(height, width);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double d = std::abs(0.6 * (x - 30.0) - 0.8 * (y - 20.0));
            image(y, x) = static_cast<std::uint8_t>(random.uniform(110.0, 130.0) - (d < 1.2 ? 60.0 : 0.0));
        }
    return image;
}

TEST(RidgeFilter, is_frangis_formula) {
    const cv::Mat1b image = noise_with_line(61, 43);
    std::vector<float> gray(image.begin(), image.end());
    RidgeFilter filter({.sigmas_px = {1.3}, .blobness = 0.5, .contrast_levels = 8.0});
    std::vector<float> ridge;
    filter.apply(gray.data(), 61, 43, 61, {0, 0, 61, 43}, ridge);
    for (int y = 0; y < 43; ++y)
        for (int x = 0; x < 61; ++x)
            ASSERT_NEAR(ridge[static_cast<std::size_t>(y * 61 + x)],
                        support::scalar_ridge(image, x, y, 1.3, 0.5, 8.0), 2e-4);
}

TEST(RidgeFilter, sees_dark_or_bright_lines_as_told) {
    cv::Mat1f image(21, 21, 100.0f);
    image.row(10) = 160.0f;
    const auto response = [&](scenes::ThreadPolarity polarity) {
        RidgeFilter filter({.sigmas_px = {1.0}, .polarity = polarity});
        std::vector<float> ridge;
        filter.apply(image.ptr<float>(), 21, 21, 21, {0, 0, 21, 21}, ridge);
        return ridge[10 * 21 + 10];
    };
    EXPECT_GT(response(scenes::ThreadPolarity::kBright), 0.9f);
    EXPECT_GT(response(scenes::ThreadPolarity::kEither), 0.9f);
    EXPECT_EQ(response(scenes::ThreadPolarity::kDark), 0.0f);
}

TEST(CostImage, has_the_same_bytes_in_a_region_as_in_the_whole) {
    const support::SyntheticSequence sequence(
        {.seed = 3, .rig = scenes::parallel_rig(320, 180, 287.5, 0.005)});
    const cv::Mat1b picture = sequence.frame(0).left;
    const auto bytes = [](const CostImage& cost, const cv::Rect& region) {
        std::vector<std::uint8_t> values;
        for (int y = region.y; y < region.br().y; ++y)
            for (int x = region.x; x < region.br().x; ++x)
                values.push_back(static_cast<std::uint8_t>(cost.row(y)[x] & 255));
        return values;
    };
    scenes::TrackerConfig config;
    CostImageMaker whole(config, {0.9, 1.35}, 15);
    CostImageMaker part(config, {0.9, 1.35}, 15);
    whole.make(picture, {0, 0, 320, 180});
    scenes::RandomStream random(1, "regions");
    for (int i = 0; i < 20; ++i) {
        const int x = static_cast<int>(random.integer(300));
        const int y = static_cast<int>(random.integer(170));
        const cv::Rect region(x, y, 1 + static_cast<int>(random.integer(static_cast<std::uint64_t>(320 - x))),
                              1 + static_cast<int>(random.integer(static_cast<std::uint64_t>(180 - y))));
        part.make(picture, region);
        ASSERT_EQ(bytes(part.cost(), region), bytes(whole.cost(), region));
        // More of the same frame: what was there stays.
        const cv::Rect more(static_cast<int>(random.integer(200)), static_cast<int>(random.integer(100)), 90,
                            70);
        part.want(more);
        part.compute();
        ASSERT_EQ(bytes(part.cost(), region), bytes(whole.cost(), region));
        ASSERT_EQ(bytes(part.cost(), more), bytes(whole.cost(), more));
    }
}

TEST(CostImage, is_bilinear_between_pixels_and_full_outside) {
    const cv::Mat1b picture = noise_with_line(61, 43);
    CostImageMaker maker(scenes::TrackerConfig{}, {1.0}, 10);
    const CostImage& cost = maker.make(picture, {0, 0, 61, 43});
    EXPECT_FLOAT_EQ(cost.at(-5.0f, 10.0f), 10.0f);
    EXPECT_FLOAT_EQ(cost.at(30.0f, 1e9f), 10.0f);
    EXPECT_NEAR(cost.at(30.25f, 20.0f), 0.75f * cost.at(30.0f, 20.0f) + 0.25f * cost.at(31.0f, 20.0f), 1e-5);
    EXPECT_FLOAT_EQ(cost.at(NAN, 10.0f), 10.0f);
    alignas(32) float u[8], v[8], many[8];
    for (int i = 0; i < 8; ++i) {
        u[i] = 3.3f * static_cast<float>(i) - 2.0f;
        v[i] = 6.1f * static_cast<float>(i);
    }
    _mm256_store_ps(many, bilinear(cost, _mm256_load_ps(u), _mm256_load_ps(v)));
    for (int i = 0; i < 8; ++i) EXPECT_NEAR(cost.unit_px * many[i], cost.at(u[i], v[i]), 1e-4);
}

TEST(CostImage, takes_a_colour_picture_like_its_gray_one) {
    const cv::Mat1b gray = noise_with_line(61, 43);
    cv::Mat3b colour(gray.size());
    for (int y = 0; y < gray.rows; ++y)
        for (int x = 0; x < gray.cols; ++x) colour(y, x) = cv::Vec3b::all(gray(y, x));
    CostImageMaker one(scenes::TrackerConfig{}, {1.0}, 15);
    CostImageMaker other(scenes::TrackerConfig{}, {1.0}, 15);
    one.make(gray, {0, 0, 61, 43});
    other.make(colour, {0, 0, 61, 43});
    EXPECT_EQ(cv::countNonZero(one.pictures().mask != other.pictures().mask), 0);
    EXPECT_THROW(one.make(cv::Mat1f(4, 4), {0, 0, 4, 4}), std::invalid_argument);
}

}  // namespace
}  // namespace atropos::tracker
