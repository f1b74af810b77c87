/**
 * @class   vtkTreeAMRFromTable
 * @brief   makes a vtkHyperTreeGrid of a table with a row for each cell of an octree
 *
 * Four columns of whole numbers say where a cell is: its level, 0 for those as large as the roots, and its indices along x,
 * y and z among the cells of that level, from 0 on. The cell is Spacing / 2^level wide then and begins at Origin + index
 * times that. Rows come in any order; where there is none the grid is masked. Input is a vtkTable or a composite data set
 * of them, all of which become one grid.
 *
 * All other columns, or the levels if there are none, become cell arrays, of their own names, types, components and values;
 * those of text are left out, as are columns that not all tables have alike, which a warning names. A coarse cell has the
 * mean of its children in arrays of float and double and the value of its first child in others.
 *
 * Of rows at one place the first counts. An error names the first row whose numbers are none of a cell, and cells that
 * overlap; the output is empty then. Of no rows it is empty, too, without an error.
 *
 * In parallel the first process makes all of the grid: see vtkTreeAMRGridAlgorithm.
 */
#ifndef vtkTreeAMRFromTable_h
#define vtkTreeAMRFromTable_h

#include "vtkTreeAMRGridAlgorithm.h"
#include "vtkTreeAMRReaderModule.h"

#include <array>  // for columns
#include <string> // for column names

class VTKTREEAMRREADER_EXPORT vtkTreeAMRFromTable : public vtkTreeAMRGridAlgorithm
{
public:
  static vtkTreeAMRFromTable* New();
  vtkTypeMacro(vtkTreeAMRFromTable, vtkTreeAMRGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Names of the columns; level, i, j and k by default.
   */
  vtkSetMacro(LevelColumn, std::string);
  vtkGetMacro(LevelColumn, std::string);
  vtkSetMacro(IColumn, std::string);
  vtkGetMacro(IColumn, std::string);
  vtkSetMacro(JColumn, std::string);
  vtkGetMacro(JColumn, std::string);
  vtkSetMacro(KColumn, std::string);
  vtkGetMacro(KColumn, std::string);
  ///@}

  ///@{
  /**
   * Where the first root begins, and how wide each is; (0, 0, 0) and (1, 1, 1) by default. A spacing that is not positive,
   * or one of the two that is not finite, is an error.
   */
  vtkSetVector3Macro(Origin, double);
  vtkGetVector3Macro(Origin, double);
  vtkSetVector3Macro(Spacing, double);
  vtkGetVector3Macro(Spacing, double);
  ///@}

  ///@{
  /**
   * Roots along each axis; 0, the default, is as many as the cells need. Cells beyond them are an error.
   */
  vtkSetVector3Macro(Roots, int);
  vtkGetVector3Macro(Roots, int);
  ///@}

protected:
  vtkTreeAMRFromTable() = default;
  ~vtkTreeAMRFromTable() override = default;

  const char* GetInputKind() const override;
  int FillInputPortInformation(int port, vtkInformation* info) override;
  void Convert(const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output) override;

private:
  std::array<std::string, 4> ColumnNames() const;

  std::string LevelColumn = "level";
  std::string IColumn = "i";
  std::string JColumn = "j";
  std::string KColumn = "k";
  double Origin[3] = { 0., 0., 0. };
  double Spacing[3] = { 1., 1., 1. };
  int Roots[3] = { 0, 0, 0 };

  vtkTreeAMRFromTable(const vtkTreeAMRFromTable&) = delete;
  void operator=(const vtkTreeAMRFromTable&) = delete;
};

#endif
