#include "scenes/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numeric>
#include <vector>

#include "scenes/file_error.hpp"

namespace atropos::scenes {
namespace {

/// Byte offset of the first byte that is not UTF-8 text (control characters other than white space included).
std::size_t first_bad_byte(std::string_view text) {
    for (std::size_t i = 0; i < text.size();) {
        const auto c = static_cast<unsigned char>(text[i]);
        std::size_t extra = 0;
        if (c < 0x80) {
            if (c < 0x20 && c != '\n' && c != '\r' && c != '\t') return i;
        } else if (c >= 0xc2 && c < 0xe0) {
            extra = 1;
        } else if (c >= 0xe0 && c < 0xf0) {
            extra = 2;
        } else if (c >= 0xf0 && c < 0xf5) {
            extra = 3;
        } else {
            return i;
        }
        for (std::size_t k = 1; k <= extra; ++k)
            if (i + k >= text.size() || (static_cast<unsigned char>(text[i + k]) & 0xc0) != 0x80) return i;
        i += extra + 1;
    }
    return std::string_view::npos;
}

}  // namespace

bool file_exists(const std::filesystem::path& file) {
    std::error_code error;
    return std::filesystem::exists(file, error);
}

std::string read_text_file(const std::filesystem::path& file, std::size_t max_bytes) {
    const std::string name = file.string();
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status)) throw FileError(name, "no such file");
    if (!std::filesystem::is_regular_file(status)) throw FileError(name, "not a regular file");
    const auto size = std::filesystem::file_size(file, error);
    if (!error && size > max_bytes)
        throw FileError(name, std::to_string(size) + " bytes, expected at most " + std::to_string(max_bytes));
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw FileError(name, "can't be read");
    std::string text;
    text.reserve(error ? 0 : static_cast<std::size_t>(size) + 1);
    // In pieces: what the file system says of the size may be wrong, and the limit may be large.
    for (std::array<char, 65536> piece{}; stream && text.size() <= max_bytes;) {
        stream.read(piece.data(), piece.size());
        text.append(piece.data(), static_cast<std::size_t>(stream.gcount()));
    }
    if (stream.bad()) throw FileError(name, "can't be read");
    if (text.size() > max_bytes)
        throw FileError(name, "expected at most " + std::to_string(max_bytes) + " bytes");
    if (text.empty()) throw FileError(name, "empty file");
    if (const std::size_t bad = first_bad_byte(text); bad != std::string_view::npos) {
        const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(bad), '\n');
        throw FileError(name, static_cast<int>(line), "not text, expected UTF-8");
    }
    return text;
}

std::optional<double> parse_number(std::string_view text) {
    if (text.starts_with('+')) text.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::optional<long long> parse_integer(std::string_view text) {
    long long value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

double in_si(double value, double unit) {
    return unit == 1e-3 ? value / 1e3 : value * unit;
}

std::string decimal(double value, double unit) {
    std::string text;
    for (int digits = 6; digits <= 17; ++digits) {
        text = fmt::format("{:.{}g}", value / unit, digits);
        if (in_si(*parse_number(text), unit) == value) break;
    }
    return text;
}

std::string shown(std::string_view text) {
    std::string out = "'";
    for (const char c : text.substr(0, 40)) out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    return out + (text.size() > 40 ? "...'" : "'");
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
        }
    }
    return row[b.size()];
}

}  // namespace atropos::scenes
