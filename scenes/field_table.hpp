#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace atropos::scenes {

struct SceneConfig;

/// Allowed values, in the file's unit.
struct Range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool without_low = false;  ///< `low` itself is not allowed
};

inline Range positive(double high = std::numeric_limits<double>::infinity()) {
    return {0.0, high, true};
}

/// Key and meaning of a field, as they stand in the file and in docs/scene.md.
struct Field {
    std::string_view key;
    std::string_view doc;
};

/// Words a text field may be; empty: any text.
using Words = std::vector<std::string_view>;

/// What is done with each field of a scene: reading, writing and documenting visit the same table.
/// The unit of a number stands in its key (`_mm`, `_deg`, `_ms`, ...); values in the struct are SI.
class FieldVisitor {
  public:
    virtual ~FieldVisitor() = default;
    virtual void number(const Field&, double& value, const Range&) = 0;
    virtual void integer(const Field&, int& value, int low, int high) = 0;
    virtual void seed(const Field&, std::uint64_t& value) = 0;
    virtual void flag(const Field&, bool& value) = 0;
    virtual void text(const Field&, std::string& value, const Words& words) = 0;
    virtual void path(const Field&, std::string& value) = 0;
    virtual void vector(const Field&, Eigen::Vector3d& value, const Range&) = 0;
    virtual void vectors(const Field&, std::vector<Eigen::Vector3d>& values, const Range&) = 0;
    virtual void section(const Field&, const std::function<void()>& fields) = 0;

    /// An enumeration by its words, in the order of the enumerators.
    template <class Enum>
    void choice(const Field& field, Enum& value, const Words& words) {
        std::string word(words[static_cast<size_t>(value)]);
        text(field, word, words);
        for (size_t i = 0; i < words.size(); ++i)
            if (words[i] == word) value = static_cast<Enum>(i);
    }
};

/// Factor from a key's unit to SI, by the key's ending; 1 when it names none.
double unit_of_key(std::string_view key);

/// Every field of a scene file, once.
void visit_fields(FieldVisitor& visitor, SceneConfig& scene);

}  // namespace atropos::scenes
