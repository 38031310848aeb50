#include "experiments/csv_file.hpp"

#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {
using scenes::FileError;

namespace {
constexpr std::size_t kMaxBytes = std::size_t{4} << 30;
}

std::vector<std::string> split_fields(std::string_view line) {
    std::vector<std::string> fields;
    while (true) {
        const std::size_t comma = line.find(',');
        fields.emplace_back(line.substr(0, comma));
        if (comma == std::string_view::npos) return fields;
        line.remove_prefix(comma + 1);
    }
}

CsvFile CsvFile::read(const std::filesystem::path& file, std::string_view header) {
    const std::string text = scenes::read_text_file(file, kMaxBytes);
    CsvFile csv;
    csv.name_ = file.string();
    std::string_view rest = text;
    for (int line = 1; !rest.empty(); ++line) {
        const std::size_t end = rest.find('\n');
        std::string_view row = rest.substr(0, end);
        rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
        if (row.ends_with('\r')) row.remove_suffix(1);
        if (line == 1) {
            if (row != header)
                throw FileError(
                    csv.name_, 1,
                    "columns are " + scenes::shown(row) + ", expected '" + std::string(header) + "'");
            csv.columns_ = split_fields(row);
            continue;
        }
        if (row.empty()) continue;
        csv.rows_.push_back(split_fields(row));
        csv.lines_.push_back(line);
        if (csv.rows_.back().size() != csv.columns_.size())
            throw FileError(csv.name_, line,
                            std::to_string(csv.rows_.back().size()) + " fields, expected " +
                                std::to_string(csv.columns_.size()));
    }
    return csv;
}

double CsvFile::number(std::size_t row, std::size_t column) const {
    const auto value = scenes::parse_number(text(row, column));
    if (!value)
        fail(row,
             columns_[column] + " is " + scenes::shown(text(row, column)) + ", expected a finite number");
    return *value;
}

long CsvFile::integer(std::size_t row, std::size_t column, long low, long high) const {
    const auto value = scenes::parse_integer(text(row, column));
    if (!value || *value < low || *value > high)
        fail(row, columns_[column] + " is " + scenes::shown(text(row, column)) +
                      ", expected a whole number from " + std::to_string(low) + " to " +
                      std::to_string(high));
    return static_cast<long>(*value);
}

void CsvFile::fail(std::size_t row, const std::string& what) const {
    throw FileError(name_, lines_[row], what);
}

}  // namespace atropos::experiments
