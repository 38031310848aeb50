#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace atropos::experiments {

/// A CSV file with a fixed header, checked as a whole when read. Fields are without quotes or commas.
class CsvFile {
  public:
    /// Throws scenes::FileError unless the first line is `header` (or, with `more_columns`, begins with it)
    /// and every row has as many fields as the header.
    static CsvFile read(const std::filesystem::path& file, std::string_view header);

    std::size_t rows() const { return rows_.size(); }
    const std::string& text(std::size_t row, std::size_t column) const { return rows_[row][column]; }

    /// Throws scenes::FileError with the line when the field is no finite number / whole number in [low,
    /// high].
    double number(std::size_t row, std::size_t column) const;
    long integer(std::size_t row, std::size_t column, long low, long high) const;
    bool empty(std::size_t row, std::size_t column) const { return rows_[row][column].empty(); }

    [[noreturn]] void fail(std::size_t row, const std::string& what) const;

  private:
    std::string name_;
    std::vector<std::string> columns_;
    std::vector<std::vector<std::string>> rows_;
    std::vector<int> lines_;
};

/// The fields of a line between commas.
std::vector<std::string> split_fields(std::string_view line);

}  // namespace atropos::experiments
