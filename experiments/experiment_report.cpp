#include "experiments/experiment_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "experiments/output_folder.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kWorstFrames = 12;

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '&')
            out += "&amp;";
        else if (c == '<')
            out += "&lt;";
        else if (c == '"')
            out += "&quot;";
        else
            out += c;
    }
    return out;
}

std::string bytes_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::string base64(const std::string& bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned value = 0;
        for (std::size_t k = 0; k < 3; ++k)
            value = value << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            out += i + k <= bytes.size() ? kDigits[value >> (18 - 6 * k) & 63u] : '=';
    }
    return out;
}

/// Markdown as `markdown_tables` writes it, as HTML: headings, tables, paragraphs.
std::string html_of(const std::string& markdown) {
    std::string html;
    bool in_table = false;
    for (std::size_t at = 0; at < markdown.size();) {
        const std::size_t end = std::min(markdown.find('\n', at), markdown.size());
        const std::string line = markdown.substr(at, end - at);
        at = end + 1;
        const bool row = line.starts_with("|");
        if (row && line.starts_with("|---")) continue;
        if (row) {
            const char* cell = in_table ? "td" : "th";
            if (!in_table) html += "<table>\n";
            in_table = true;
            html += "<tr>";
            for (std::size_t from = 1; from < line.size();) {
                const std::size_t bar = std::min(line.find('|', from), line.size());
                html += fmt::format("<{0}>{1}</{0}>", cell, escaped(line.substr(from, bar - from)));
                from = bar + 1;
            }
            html += "</tr>\n";
            continue;
        }
        if (in_table) html += "</table>\n";
        in_table = false;
        if (line.starts_with("## "))
            html += "<h2>" + escaped(line.substr(3)) + "</h2>\n";
        else if (line.starts_with("# "))
            html += "<h1>" + escaped(line.substr(2)) + "</h1>\n";
        else if (!line.empty())
            html += "<p>" + escaped(line) + "</p>\n";
    }
    return html + (in_table ? "</table>\n" : "");
}

std::string plots_html(const fs::path& folder) {
    std::vector<fs::path> drawings;
    if (fs::is_directory(folder))
        for (const auto& entry : fs::directory_iterator(folder))
            if (entry.path().extension() == ".svg") drawings.push_back(entry.path());
    std::sort(drawings.begin(), drawings.end());
    std::string html;
    for (const fs::path& drawing : drawings)
        html += fmt::format(
            "<figure><img alt=\"{0}\" "
            "src=\"data:image/svg+xml;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
            escaped(drawing.stem().string()), base64(bytes_of(drawing)));
    return html.empty() ? html : "<h2>Plots</h2>\n" + html;
}

struct Worst {
    double symmetric_2d_px;
    std::string job, where, sequence;
    long frame, base_frame;
};

std::string worst_html(const ExperimentResults& results, const fs::path& folder) {
    std::vector<Worst> all;
    for (const auto& cell : results.manifest["cells"]) {
        const std::string id = cell["job"];
        const auto result = results.by_job.find(id);
        if (result == results.by_job.end() || !result->second.contains("worst")) continue;
        const auto& worst = result->second["worst"];
        std::string where;
        for (const auto& [factor, level] : cell["levels"].items())
            where += factor + " " + level.get<std::string>() + ", ";
        where += fmt::format("seed {}", cell["seed"].dump());
        all.push_back({worst["symmetric_2d_px"].get<double>(), id, where,
                       worst["sequence"].get<std::string>(), worst["frame"].get<long>(),
                       worst["base_frame"].get<long>()});
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Worst& a, const Worst& b) { return a.symmetric_2d_px > b.symmetric_2d_px; });
    all.erase(
        std::unique(all.begin(), all.end(), [](const Worst& a, const Worst& b) { return a.job == b.job; }),
        all.end());
    if (all.size() > kWorstFrames) all.resize(kWorstFrames);
    std::string html;
    for (const Worst& w : all)
        html += fmt::format(
            "<details><summary>{:.2f} px: {}, frame {}</summary>\n<img alt=\"left and right picture with "
            "estimate and truth\" "
            "src=\"data:image/jpeg;base64,{}\">\n<p>With sequences kept (<code>--keep all</code>): "
            "<code>atropos track "
            "sequences/{} -o explained --config jobs/{}/scene.yaml --explain {}</code></p></details>\n",
            w.symmetric_2d_px, escaped(w.where), w.frame,
            base64(bytes_of(folder / "jobs" / w.job / "worst.jpg")), w.sequence, w.job, w.base_frame);
    return html.empty() ? html : "<h2>Worst frames</h2>\n" + html;
}

}  // namespace

void write_report(const ExperimentResults& results, const fs::path& folder) {
    const std::string page =
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
        escaped(results.manifest["title"].get<std::string>()) +
        "</title>\n<style>body{font:15px/1.5 sans-serif;max-width:75em;margin:2em auto;padding:0 "
        "1em;color:#222}"
        "table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:.2em .6em;text-align:left}"
        "img{max-width:100%}figure{display:inline-block;margin:.5em}summary{cursor:pointer}code{background:#"
        "f2f2f2}"
        "</style></head>\n<body>\n" +
        html_of(markdown_tables(results)) + plots_html(folder / "plots") + worst_html(results, folder) +
        "</body></html>\n";
    write_file(folder / "report.html.tmp", page);
    fs::rename(folder / "report.html.tmp", folder / "report.html");
}

}  // namespace atropos::experiments
