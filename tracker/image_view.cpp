#include "tracker/image_view.hpp"

#include <opencv2/imgproc.hpp>

namespace atropos::tracker {

ImageView channel_view(const cv::Mat& image, scenes::ImageChannel channel, cv::Mat& buffer) {
    ImageView view{image.data, static_cast<std::ptrdiff_t>(image.step), image.channels(), image.cols,
                   image.rows};
    if (image.channels() == 1) return view;
    switch (channel) {
        case scenes::ImageChannel::kBlue:
            return view;
        case scenes::ImageChannel::kGreen:
            view.data += 1;
            return view;
        case scenes::ImageChannel::kRed:
            view.data += 2;
            return view;
        case scenes::ImageChannel::kGray:
            break;
    }
    cv::cvtColor(image, buffer, cv::COLOR_BGR2GRAY);
    return {buffer.data, static_cast<std::ptrdiff_t>(buffer.step), 1, buffer.cols, buffer.rows};
}

}  // namespace atropos::tracker
