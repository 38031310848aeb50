// The program on meshes and pictures that are broken or meant to break it: one line, status 2, within seconds
// and in bounded memory.
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <cstdlib>
#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "tests/experiments/temporary_folder.hpp"

namespace atropos::experiments {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

struct Hostile {
    std::string file, bytes;
};

std::string little_endian(std::uint32_t value) {
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &value, 4);
    return bytes;
}

std::string big_endian(std::uint32_t value) {
    const std::string bytes = little_endian(value);
    return {bytes.rbegin(), bytes.rend()};
}

std::string floats(std::initializer_list<float> values) {
    std::string bytes;
    for (const float v : values) {
        bytes.append(4, '\0');
        std::memcpy(bytes.data() + bytes.size() - 4, &v, 4);
    }
    return bytes;
}

std::string junk(std::size_t size) {
    std::string bytes(size, '\0');
    std::uint32_t state = 7;
    for (char& c : bytes) c = static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
    return bytes;
}

std::string binary_stl(std::uint32_t count, const std::string& triangles) {
    return std::string(80, ' ') + little_endian(count) + triangles;
}

std::string ply(const std::string& vertices, const std::string& faces, const std::string& body,
                const std::string& format = "ascii") {
    return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list uchar int vertex_indices\nend_header\n" + body;
}

std::string encoded(const std::string& extension, int width, int height) {
    std::vector<std::uint8_t> bytes;
    cv::Mat picture(height, width, CV_8UC3);
    cv::randu(picture, 0, 256);
    cv::imencode(extension, picture, bytes);
    return {bytes.begin(), bytes.end()};
}

/// A PNG's signature and header; the sum over it is wrong.
std::string png_header(std::uint32_t width, std::uint32_t height) {
    return "\x89PNG\r\n\x1a\n" + big_endian(13) + "IHDR" + big_endian(width) + big_endian(height) +
           std::string("\x08\x02\x00\x00\x00", 5) + big_endian(0);
}

std::string jpeg_header(const std::string& height_width) {
    return std::string("\xff\xd8\xff\xc0\x00\x11\x08", 7) + height_width +
           std::string("\x03\x01\x22\x00\x02\x11\x01\x03\x11\x01", 10);
}

std::vector<Hostile> hostile_meshes() {
    const float nan = std::nanf(""), inf = HUGE_VALF;
    const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n", zero = floats({0, 0, 0}), end(2, '\0');
    std::string laughs = "<?xml version=\"1.0\"?><!DOCTYPE a [<!ENTITY a \"ha\">";
    for (char c = 'b'; c < 'z'; ++c) {
        laughs += std::string("<!ENTITY ") + c + " \"";
        for (int i = 0; i < 10; ++i) laughs += std::string("&") + static_cast<char>(c - 1) + ";";
        laughs += "\">";
    }
    laughs += "]><COLLADA version=\"1.4.1\">&y;</COLLADA>";
    const std::string gltf = R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)";
    const std::string views =
        R"(],"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,)"
        R"("count":3,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
        R"("nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0})";
    return {
        {"empty.obj", ""},
        {"comment.obj", "# nothing\n"},
        {"faces_without_vertices.obj", "f 1 2 3\n"},
        {"vertices_without_faces.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"},
        {"far_index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 999999999\n"},
        {"index_before_first.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -9 -8 -7\n"},
        {"index_overflow.obj", "v 0 0 0\nf 99999999999999999999 1 1\n"},
        {"nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
        {"overflow.obj", "v 1e999 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
        {"one_corner.obj", "v 0 0 0\nf 1\n"},
        {"words.obj", "this is a letter, not a mesh\n"},
        {"junk.obj", junk(5000)},
        {"long_line.obj", "v " + std::string(3 << 20, '1')},
        {"zeros.obj", std::string(4096, '\0')},
        {"empty.stl", ""},
        {"short.stl", "stl"},
        {"header_alone.stl", std::string(80, ' ')},
        {"no_triangles.stl", binary_stl(0, "")},
        {"truncated.stl", binary_stl(1000, std::string(120, '\1'))},
        {"huge_count.stl", binary_stl(0xffffffffu, std::string(50, '\0'))},
        {"nan.stl", binary_stl(1, zero + floats({nan, 0, 0, 1, 0, 0, 0, 1, 0}) + end)},
        {"infinite.stl", binary_stl(1, zero + floats({inf, 0, 0, 1, 0, 0, 0, 1, 0}) + end)},
        {"solid_alone.stl", "solid x\n"},
        {"cut_facet.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0"},
        {"nan_facet.stl",
         "solid x\nfacet normal 0 0 1\nouter loop\nvertex nan 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
         "endfacet\nendsolid x\n"},
        {"junk.stl", junk(5000)},
        {"empty.ply", ""},
        {"magic_alone.ply", "ply\n"},
        {"no_end.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"},
        {"huge_count.ply", ply("4000000000", "1", square)},
        {"negative_count.ply", ply("-4", "1", square)},
        {"fewer_vertices.ply", ply("40", "1", square)},
        {"far_index.ply", ply("4", "1", square + "3 0 1 77\n")},
        {"nan.ply", ply("4", "1", "nan 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n")},
        {"truncated.ply", ply("4", "1", floats({0, 0, 0, 1, 0}), "binary_little_endian")},
        {"huge_face.ply",
         ply("4", "1", floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) + "\xff", "binary_little_endian")},
        {"unknown_format.ply", ply("4", "1", square, "runes")},
        {"junk.ply", junk(5000)},
        {"empty.dae", ""},
        {"words.dae", "not XML"},
        {"no_geometry.dae", "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"></COLLADA>"},
        {"truncated.dae", "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"><library_geometries><geom"},
        {"laughs.dae", laughs},
        {"empty.gltf", ""},
        {"nothing.gltf", "{}"},
        {"truncated.gltf", gltf},
        {"huge_buffer.gltf", gltf + "99999999999}" + views},
        {"missing_buffer.gltf", gltf + R"(36,"uri":"missing.bin"})" + views},
        {"wrong_magic.glb", "glTG" + little_endian(2) + little_endian(12)},
        {"huge_chunk.glb",
         "glTF" + little_endian(2) + little_endian(28) + little_endian(0xfffffff0u) + "JSON{}      "},
        {"junk.glb", junk(5000)},
    };
}

std::vector<Hostile> hostile_pictures() {
    const std::string png = encoded(".png", 64, 64), jpeg = encoded(".jpg", 64, 64);
    std::string wrong_sum = png;
    wrong_sum[png.size() / 2] = static_cast<char>(wrong_sum[png.size() / 2] ^ 0x55);
    return {
        {"empty.png", ""},
        {"signature_alone.png", png.substr(0, 8)},
        {"header_alone.png", png.substr(0, 33)},
        {"truncated.png", png.substr(0, png.size() / 2)},
        {"wrong_sum.png", wrong_sum},
        {"huge.png", png_header(0x7fffffff, 0x7fffffff)},
        {"no_size.png", png_header(0, 0)},
        {"too_wide.png", encoded(".png", 8193, 2)},
        {"words.png", "not a picture"},
        {"junk.png", junk(5000)},
        {"empty.jpg", ""},
        {"start_alone.jpg", "\xff\xd8"},
        {"truncated.jpg", jpeg.substr(0, jpeg.size() / 2)},
        {"huge.jpg", jpeg_header("\xff\xff\xff\xff")},
        {"no_size.jpg", jpeg_header(std::string(4, '\0'))},
        {"junk.jpg", junk(5000)},
    };
}

class HostileFilesTest : public TemporaryFolder {
  protected:
    /// Runs the program in 4 GB of address space and expects one line and status 2.
    void expect_refusal(const std::string& words, const std::string& environment = "") const {
        const fs::path out = folder_ / "out.txt", complaint = folder_ / "complaint.txt";
        const std::string command = "ulimit -v 4000000; " + environment +
                                    " timeout 20 '" ATROPOS_PROGRAM "' " + words + " >'" + out.string() +
                                    "' 2>'" + complaint.string() + "'";
        const int status = std::system(command.c_str());
        ASSERT_TRUE(WIFEXITED(status)) << words;
        EXPECT_EQ(WEXITSTATUS(status), 2) << words << ": " << read(complaint) << read(out);
        const std::string line = read(complaint);
        EXPECT_THAT(line, StartsWith("atropos: ")) << words;
        EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << words << ": " << line;
        EXPECT_LT(line.size(), 600u) << words;
        EXPECT_EQ(read(out), "") << words;
    }
};

TEST_F(HostileFilesTest, meshes_are_refused_in_one_line) {
    for (const Hostile& mesh : hostile_meshes()) {
        write(mesh.file, mesh.bytes);
        expect_refusal("info '" + (folder_ / mesh.file).string() + "' --scale-to-m 0.001");
    }
}

TEST_F(HostileFilesTest, pictures_are_refused_in_one_line) {
    for (const Hostile& picture : hostile_pictures()) {
        write(picture.file, picture.bytes);
        expect_refusal("info '" + (folder_ / picture.file).string() + "'");
    }
}

TEST_F(HostileFilesTest, what_is_no_file_is_refused_in_one_line) {
    fs::create_directories(folder_ / "folder.obj");
    fs::create_directories(folder_ / "folder.png");
    fs::create_symlink(folder_ / "nowhere.stl", folder_ / "dangling.stl");
    ASSERT_EQ(mkfifo((folder_ / "pipe.ply").c_str(), 0600), 0);
    for (const char* name : {"folder.obj", "folder.png", "dangling.stl", "pipe.ply", "missing.obj"})
        expect_refusal("info '" + (folder_ / name).string() + "' --scale-to-m 0.001");
    write("good.stl", "solid x\n");
    expect_refusal("info '" + (folder_ / "good.stl").string() + "'");
    EXPECT_THAT(read(folder_ / "complaint.txt"), HasSubstr("expected --scale-to-m"));
}

TEST_F(HostileFilesTest, a_renderer_that_cannot_be_loaded_is_told_in_one_line) {
    const std::string render =
        "render '" ATROPOS_SCENES "/auto_scissors.yaml' -o '" + (folder_ / "still.png").string() + "'";
    for (const char* library : {"libOSMesa.so.8", "libEGL.so.1"}) write(library, "not a library");
    const std::string found_first = "LD_LIBRARY_PATH='" + folder_.string() + "'";
    expect_refusal(render, found_first);
    EXPECT_THAT(read(folder_ / "complaint.txt"), HasSubstr("libosmesa6"));
    expect_refusal(render + " --set render.back_end=egl", found_first);
    EXPECT_THAT(read(folder_ / "complaint.txt"), HasSubstr("libegl1"));
    expect_refusal(render + " --set render.back_end=egl", "__EGL_VENDOR_LIBRARY_DIRS=/nonexistent");
    EXPECT_THAT(read(folder_ / "complaint.txt"), HasSubstr("no surfaceless display"));
}

TEST_F(HostileFilesTest, meshes_of_an_arm_are_refused_before_anything_is_drawn) {
    write("own/shaft.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    fs::create_directories(folder_ / "none");
    const std::string render = "render '" ATROPOS_SCENES "/auto_scissors.yaml' -o '" +
                               (folder_ / "still.png").string() + "' --set arms.PSM1.meshes='" +
                               folder_.string();
    expect_refusal(render + "/own' --set arms.PSM1.mesh_scale_m=0.001");
    expect_refusal(render + "/own'");
    EXPECT_THAT(read(folder_ / "complaint.txt"), HasSubstr("mesh_scale_m"));
    expect_refusal(render + "/none' --set arms.PSM1.mesh_scale_m=0.001");
    EXPECT_FALSE(fs::exists(folder_ / "still.png"));
}

}  // namespace
}  // namespace atropos::experiments
