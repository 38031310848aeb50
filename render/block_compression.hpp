#pragma once

#include <opencv2/core.hpp>

namespace atropos::render {

/// What JPEG at a quality (1-100, the Independent JPEG Group's scale) leaves of a picture: Y Cb Cr with
/// chroma at half size, 8x8 cosine transform, quantisation by the tables of ITU-T T.81 annex K, and back.
/// Entropy coding loses nothing and is left out. `picture`: CV_8UC3, B G R; any size.
cv::Mat compressed(const cv::Mat& picture, int quality);

}  // namespace atropos::render
