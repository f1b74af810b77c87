// The figures of one data set after the other as a table, then all of them as JSON.
#pragma once

#include <string>
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
};

class Report
{
public:
  /// Prints it. All rows have the same figures.
  void add(Row row);
  /// Throws Error when the file cannot be written.
  void writeJson(const std::string& path) const;

private:
  std::vector<Row> rows_;
};

} // namespace treeamr::bench
