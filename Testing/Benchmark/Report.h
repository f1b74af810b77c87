// The figures of one data set after the other as a table, then all of them as JSON.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace treeamr::bench
{

struct Figure
{
  const char* key; // in the JSON; null: in the table only
  double value;
  const char* heading = nullptr; // in the table; null: in the JSON only
  int decimals = 0;              // in the table
  double scale = 1.;             // to the table's unit
};

struct Row
{
  std::string dataSet;
  std::vector<Figure> figures;
  std::vector<std::pair<const char*, std::string>> labels = {}; // key and value; columns of the table, too
};

class Report
{
public:
  /// key: of the list in the JSON.
  explicit Report(const char* key)
    : key_(key)
  {
  }
  /// Prints it. All rows have the same figures.
  void add(Row row);

private:
  friend void writeJson(const std::string& path, const std::vector<const Report*>& reports);

  const char* key_;
  std::vector<Row> rows_;
};

/// Those with rows. Throws Error when the file cannot be written.
void writeJson(const std::string& path, const std::vector<const Report*>& reports);

} // namespace treeamr::bench
