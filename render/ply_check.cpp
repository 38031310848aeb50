#include "render/ply_check.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>
#include <vector>

#include "scenes/file_error.hpp"

namespace atropos::render {
namespace {

struct Property {
    std::string name;
    char count_type = 0;  // of a list; 0: a single value
    char type = 0;
};

struct Element {
    std::string name;
    double count = 0.0;
    std::vector<Property> properties;
};

/// b, s, i: signed of 1, 2, 4 bytes; B, S, I: unsigned; f, d: floating point; 0: no such type.
char type_of(std::string_view word) {
    static constexpr std::pair<std::string_view, char> kTypes[] = {
        {"char", 'b'},   {"int8", 'b'},    {"uchar", 'B'},  {"uint8", 'B'},  {"short", 's'}, {"int16", 's'},
        {"ushort", 'S'}, {"uint16", 'S'},  {"int", 'i'},    {"int32", 'i'},  {"uint", 'I'},  {"uint32", 'I'},
        {"float", 'f'},  {"float32", 'f'}, {"double", 'd'}, {"float64", 'd'}};
    for (const auto& [name, type] : kTypes)
        if (name == word) return type;
    return 0;
}

class PlyFile {
  public:
    explicit PlyFile(const std::string& file) : file_(file) {
        std::ifstream stream(file, std::ios::binary);
        bytes_.assign(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    }

    void check() {
        read_header();
        for (const Element& element : elements_)
            for (double i = 0; i < element.count; ++i)
                for (const Property& property : element.properties) check_property(element, property);
    }

  private:
    [[noreturn]] void fail(const std::string& what) const {
        throw scenes::FileError(file_, what + ", expected a whole PLY file");
    }

    std::string_view line() {
        const std::size_t end = bytes_.find('\n', at_);
        if (end == std::string::npos) fail("its header has no end");
        std::string_view text = std::string_view(bytes_).substr(at_, end - at_);
        at_ = end + 1;
        if (text.ends_with('\r')) text.remove_suffix(1);
        return text;
    }

    void read_header() {
        if (line() != "ply") fail("does not begin with ply");
        for (std::string_view text = line(); text != "end_header"; text = line()) {
            std::istringstream words{std::string(text)};
            std::string word, first, second, third;
            words >> word >> first >> second >> third;
            if (word == "format") {
                ascii_ = first == "ascii";
                swapped_ = (first == "binary_big_endian") != (std::endian::native == std::endian::big);
                if (!ascii_ && first != "binary_little_endian" && first != "binary_big_endian")
                    fail("unknown format");
                known_format_ = true;
            } else if (word == "element") {
                Element element{first, std::strtod(second.c_str(), nullptr), {}};
                if (!(element.count >= 0.0 && element.count <= static_cast<double>(bytes_.size())))
                    fail("more elements in its header than bytes in the file");
                elements_.push_back(element);
                if (first == "vertex") vertices_ = element.count;
            } else if (word == "property") {
                if (elements_.empty()) fail("a property of no element");
                Property property{second, 0, type_of(first)};
                if (first == "list") {
                    words >> property.name;
                    property.count_type = type_of(second);
                    property.type = type_of(third);
                    if (property.count_type == 0) fail("unknown type");
                }
                if (property.type == 0) fail("unknown type");
                elements_.back().properties.push_back(property);
            } else if (word != "comment" && word != "obj_info" && !word.empty()) {
                fail("unknown word in its header");
            }
        }
        if (!known_format_) fail("its header names no format");
    }

    void check_property(const Element& element, const Property& property) {
        if (property.count_type == 0) {
            value(property.type);
            return;
        }
        const double count = value(property.count_type);
        if (!(count >= 0.0 && count <= static_cast<double>(bytes_.size() - at_))) fail("a list of no length");
        const bool names_vertices = element.name == "face" && property.name.starts_with("vertex_ind");
        for (double k = 0; k < count; ++k) {
            const double index = value(property.type);
            if (names_vertices && !(index >= 0.0 && index < vertices_))
                fail("a face names a vertex that isn't there");
        }
    }

    double value(char type) {
        if (ascii_) return word();
        switch (type) {
            case 'b':
                return number<std::int8_t>();
            case 'B':
                return number<std::uint8_t>();
            case 's':
                return number<std::int16_t>();
            case 'S':
                return number<std::uint16_t>();
            case 'i':
                return number<std::int32_t>();
            case 'I':
                return number<std::uint32_t>();
            case 'f':
                return static_cast<double>(number<float>());
            default:
                return number<double>();
        }
    }

    template <class T>
    T number() {
        if (bytes_.size() - at_ < sizeof(T)) fail("ends early");
        char raw[sizeof(T)];
        for (std::size_t i = 0; i < sizeof(T); ++i) raw[swapped_ ? sizeof(T) - 1 - i : i] = bytes_[at_ + i];
        at_ += sizeof(T);
        T result{};
        std::memcpy(&result, raw, sizeof(T));
        return result;
    }

    double word() {
        const std::size_t begin = bytes_.find_first_not_of(" \t\r\n", at_);
        if (begin == std::string::npos) fail("ends early");
        at_ = std::min(bytes_.find_first_of(" \t\r\n", begin), bytes_.size());
        double result = 0.0;
        const char* end = bytes_.data() + at_;
        const auto [stop, error] = std::from_chars(bytes_.data() + begin, end, result);
        if (error != std::errc() || stop != end || !std::isfinite(result)) fail("a value is no number");
        return result;
    }

    std::string file_, bytes_;
    std::size_t at_ = 0;
    bool ascii_ = false, swapped_ = false, known_format_ = false;
    double vertices_ = 0.0;
    std::vector<Element> elements_;
};

}  // namespace

void check_ply(const std::string& file) {
    PlyFile(file).check();
}

}  // namespace atropos::render
