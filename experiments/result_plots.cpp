#include "experiments/result_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "experiments/output_folder.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
namespace {

/// A data file, a script that draws it, and the drawing where gnuplot is installed.
void write_plot(const Table& table, const std::string& rows, const std::string& name,
                const fs::path& folder) {
    const bool numeric = std::all_of(table.rows.begin(), table.rows.end(), [](const std::string& r) {
        return scenes::parse_number(r).has_value();
    });
    std::string data = csv_field(rows.empty() ? "row" : rows), script;
    for (const std::string& column : table.columns)
        data += fmt::format(",{0} mean,{0} std", csv_field(column));
    data += "\n";
    for (const std::string& row : table.rows) {
        data += csv_field(row);
        for (const std::string& column : table.columns) {
            const auto at = table.places.find({row, column});
            const bool known = at != table.places.end() && at->second->metrics.contains(table.metric);
            data += known ? fmt::format(",{:.6f},{:.6f}", at->second->metrics.at(table.metric).mean,
                                        at->second->metrics.at(table.metric).std)
                          : ",,";
        }
        data += "\n";
    }
    script = fmt::format(
        "# gnuplot {0}.gp draws {0}.svg\nset terminal svg size 640,400\nset output '{0}.svg'\nset datafile "
        "separator ','\nset key top left\nset grid\nset xlabel '{1}' noenhanced\nset ylabel '{2}' "
        "noenhanced\nset title '{3}' noenhanced\nset yrange [0:*]\nplot ",
        name, rows, table.metric, table.where);
    for (size_t i = 0; i < table.columns.size(); ++i)
        script += fmt::format("{}'{}.csv' skip 1 using {}:{}:{}{} with yerrorlines title '{}' noenhanced",
                              i == 0 ? "" : ", \\\n     ", name, numeric ? "1" : "0", 2 * i + 2, 2 * i + 3,
                              numeric ? "" : ":xtic(1)", table.columns[i]);
    write_file(folder / (name + ".csv"), data);
    write_file(folder / (name + ".gp"), script + "\n");
    std::string quoted;
    for (const char c : folder.string()) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    const std::string draw = fmt::format("cd '{}' && gnuplot '{}.gp' 2>/dev/null", quoted, name);
    if (std::system(draw.c_str()) != 0) {
        std::error_code error;
        fs::remove(folder / (name + ".svg"), error);
    }
}

}  // namespace

std::string csv_field(std::string text) {
    std::replace(text.begin(), text.end(), ',', ';');
    return text;
}

void write_plots(const nlohmann::ordered_json& manifest, const std::vector<CellStatistics>& cells,
                 const fs::path& folder) {
    OutputFolder plots(folder, true);
    std::map<std::string, int> used;
    for (const Table& table : layout(manifest, cells)) {
        if (table.metric == "verdict" || table.metric == "cut_error_mm") continue;
        const int number = ++used[table.metric];
        write_plot(table, manifest["table"]["rows"],
                   number == 1 ? table.metric : fmt::format("{}_{}", table.metric, number), plots.path());
    }
    plots.commit();
}

}  // namespace atropos::experiments
