#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace atropos::scenes {

/// Whether there is such a file; a name that no file can have (too long, say) is no error.
bool file_exists(const std::filesystem::path& file);

/// The whole of a text file. Throws FileError when it is missing, no regular file, larger than `max_bytes`,
/// empty, or not UTF-8 text.
std::string read_text_file(const std::filesystem::path& file, std::size_t max_bytes);

/// A finite number, the whole of `text`, independent of the locale; nullopt otherwise.
std::optional<double> parse_number(std::string_view text);

/// A whole number, the whole of `text`; nullopt otherwise or when it does not fit.
std::optional<long long> parse_integer(std::string_view text);

/// `value` times `unit`; thousandths by division, which rounds to what a person would write (5.1 mm is 0.0051
/// m).
double in_si(double value, double unit);

/// The shortest decimal d for which in_si(parse_number(d), unit) is exactly `value` (where one exists).
std::string decimal(double value, double unit = 1.0);

/// `text` shortened and made printable for an error line.
std::string shown(std::string_view text);

/// The candidate with the smallest edit distance to `word`; empty when there is none within half of its
/// length.
template <class Range>
std::string nearest_word(std::string_view word, const Range& candidates);

std::size_t edit_distance(std::string_view a, std::string_view b);

template <class Range>
std::string nearest_word(std::string_view word, const Range& candidates) {
    std::string best;
    std::size_t best_distance = word.size() / 2 + 2;
    for (const auto& candidate : candidates) {
        const std::size_t distance = edit_distance(word, candidate);
        if (distance < best_distance) {
            best_distance = distance;
            best = std::string(candidate);
        }
    }
    return best;
}

}  // namespace atropos::scenes
