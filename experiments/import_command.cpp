#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "experiments/commands.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/picture_file.hpp"
#include "experiments/version.hpp"
#include "scenes/calibration_file.hpp"
#include "scenes/file_error.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;
namespace {

struct ImportOptions {
    std::vector<std::string> videos;
    std::string calibration, output;
    double fps_hz = 0.0;
    bool right_first = false;
    CommonOptions common;
};

/// A program's stdout, read to its end. No shell: file names are only file names.
class Pipe {
  public:
    explicit Pipe(const std::vector<std::string>& arguments) : name_(arguments.front()) {
        int ends[2];
        if (pipe2(ends, O_CLOEXEC) != 0) throw FileError(name_, "no pipe");
        std::vector<char*> argv;
        for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
        argv.push_back(nullptr);
        child_ = fork();
        if (child_ == 0) {
            dup2(ends[1], STDOUT_FILENO);
            const int nothing = ::open("/dev/null", O_RDWR);
            dup2(nothing, STDIN_FILENO);
            dup2(nothing, STDERR_FILENO);
            execvp(argv[0], argv.data());
            _exit(127);
        }
        ::close(ends[1]);
        out_ = ends[0];
        if (child_ < 0) throw FileError(name_, "can't be started");
    }
    ~Pipe() {
        ::close(out_);
        if (child_ > 0) waitpid(child_, nullptr, 0);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    /// False at the end; a part of `bytes` at the very end is an end, too.
    bool read(unsigned char* bytes, std::size_t count) const {
        while (count > 0) {
            const ssize_t got = ::read(out_, bytes, count);
            if (got <= 0) return false;
            bytes += got;
            count -= static_cast<std::size_t>(got);
        }
        return true;
    }

    /// Waits for the end: true when the program is content.
    bool finish() {
        int status = 0;
        waitpid(child_, &status, 0);
        child_ = -1;
        if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
            throw FileError(name_, "no such program, expected Debian's package ffmpeg");
        return WIFEXITED(status) && WEXITSTATUS(status) == 0;
    }

  private:
    std::string name_;
    pid_t child_ = -1;
    int out_ = -1;
};

struct VideoFacts {
    cv::Size size;
    double fps_hz = 0.0;
};

VideoFacts probe(const std::string& video) {
    if (!fs::is_regular_file(video)) throw FileError(video, "no such video");
    Pipe pipe({"ffprobe", "-v", "error", "-select_streams", "v:0", "-show_entries",
               "stream=width,height,r_frame_rate", "-of", "csv=p=0", "file:" + video});
    std::string text;
    unsigned char c = 0;
    while (pipe.read(&c, 1)) text += static_cast<char>(c);
    const bool content = pipe.finish();
    int width = 0, height = 0;
    double up = 0.0, down = 0.0;
    if (!content || std::sscanf(text.c_str(), "%d,%d,%lf/%lf", &width, &height, &up, &down) != 4 ||
        !(down > 0.0) || !(up > 0.0))
        throw FileError(video, "no video that ffmpeg can read");
    return {{width, height}, up / down};
}

std::unique_ptr<Pipe> decode(const std::string& video) {
    return std::make_unique<Pipe>(std::vector<std::string>{"ffmpeg", "-v", "error", "-i", "file:" + video,
                                                           "-vsync", "passthrough", "-f", "rawvideo",
                                                           "-pix_fmt", "bgr24", "-"});
}

/// Writes every picture pair; returns how many.
long write_pictures(const ImportOptions& options, const cv::Size& whole, const cv::Size& eye,
                    const fs::path& folder) {
    std::vector<std::unique_ptr<Pipe>> videos;
    for (const std::string& video : options.videos) videos.push_back(decode(video));
    fs::create_directories(folder / "left");
    fs::create_directories(folder / "right");
    std::array<cv::Mat, 2> pictures{cv::Mat(whole, CV_8UC3), cv::Mat(whole, CV_8UC3)};
    long frames = 0;
    while (true) {
        std::array<bool, 2> got{false, false};
        for (std::size_t i = 0; i < videos.size(); ++i)
            got[i] = videos[i]->read(pictures[i].data, pictures[i].total() * pictures[i].elemSize());
        if (videos.size() == 2 && got[0] != got[1])
            throw FileError(options.videos[got[0] ? 1 : 0],
                            fmt::format("ends after {} frames, the other eye goes on", frames));
        if (!got[0]) break;
        const bool apart = videos.size() == 2;
        const cv::Rect first(0, 0, eye.width, eye.height), second(eye.width, 0, eye.width, eye.height);
        cv::Mat left = apart ? pictures[0] : pictures[0](first),
                right = apart ? pictures[1] : pictures[0](second);
        if (options.right_first) std::swap(left, right);
        const std::string name = fmt::format("{:06d}.png", frames++);
        write_png(folder / "left" / name, left);
        write_png(folder / "right" / name, right);
    }
    for (std::size_t i = 0; i < videos.size(); ++i)
        if (!videos[i]->finish())
            throw FileError(options.videos[i], fmt::format("can't be decoded beyond frame {}", frames));
    return frames;
}

int import_video(const ImportOptions& options) {
    check_output(options.output, options.common.force);
    const scenes::StereoRig rig = scenes::load_calibration(options.calibration);
    const cv::Size eye(rig.left.width_px, rig.left.height_px);
    const cv::Size whole = options.videos.size() == 2 ? eye : cv::Size(2 * eye.width, eye.height);
    VideoFacts facts;
    for (const std::string& video : options.videos) {
        facts = probe(video);
        if (facts.size != whole)
            throw FileError(video, fmt::format("{}x{} px, expected {}x{} by the calibration{}",
                                               facts.size.width, facts.size.height, whole.width, whole.height,
                                               options.videos.size() == 1 ? " (side by side)" : ""));
    }
    const double fps_hz = options.fps_hz > 0.0 ? options.fps_hz : facts.fps_hz;
    OutputFolder output(options.output, options.common.force);
    const long frames = write_pictures(options, whole, eye, output.path());
    if (frames == 0) throw FileError(options.videos.front(), "no frames");
    fs::create_directories(output.path() / "calib");
    write_file(output.path() / "calib" / "stereo.yaml", scenes::to_opencv_yaml(rig));
    std::string times = "frame,time_s\n";
    for (long i = 0; i < frames; ++i) times += fmt::format("{},{:.6f}\n", i, static_cast<double>(i) / fps_hz);
    write_file(output.path() / "frames.csv", times);
    nlohmann::ordered_json meta;
    meta["name"] = fs::path(options.videos.front()).stem().string();
    meta["frames"] = frames;
    meta["fps_hz"] = fps_hz;
    meta["imported_from"] = options.videos;
    meta["versions"] = {{"atropos", version_number()}};
    meta["complete"] = true;
    write_file(output.path() / "meta.json", meta.dump(2) + "\n");
    output.commit();
    fmt::print("{} stereo frames at {:.3f} a second\n", frames, fps_hz);
    return kDone;
}

}  // namespace

void add_import_command(CLI::App& program, Command& chosen) {
    CLI::App* app = program.add_subcommand("import", "left and right, or side-by-side video to a sequence");
    const auto options = std::make_shared<ImportOptions>();
    app->add_option("VIDEO", options->videos, "left and right video, or one with both eyes side by side")
        ->required()
        ->expected(1, 2);
    app->add_option("--calib", options->calibration, "stereo calibration (OpenCV or ROS YAML, dVRK .ini)")
        ->required();
    app->add_option("-o,--output", options->output, "folder of the sequence")->required();
    app->add_option("--fps", options->fps_hz, "frames a second, when the video is wrong about it")
        ->check(CLI::Range(0.1, 10000.0));
    app->add_flag("--right-first", options->right_first, "the right eye comes first");
    app->add_flag("--force", options->common.force, "replace a non-empty output folder");
    app->footer("Example: atropos import left.mp4 right.mp4 --calib stereo.yaml -o results/recorded");
    app->callback([&chosen, options] { chosen = [options] { return import_video(*options); }; });
}

}  // namespace atropos::experiments
