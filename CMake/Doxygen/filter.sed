# A header as this project writes it, as Doxygen reads it: the comment at its beginning is of the file, one at the end of a
# line of what is declared there. What all classes of VTK have alike is left out.
1,/^[^/]/ {
  s|^//   |///     |
  s|^//\( .*\)\{0,1\}$|///\1|
}
1 i /// @file
s|^\( .*[;,]\) *// \(.*\)$|\1 ///< \2|
s|^\( *[A-Z][A-Za-z]*\) *// \(.*\)$|\1 ///< \2|
/operator==(.*) const.* = default;/d
/void PrintSelf(ostream& os, vtkIndent indent) override;/d
/^  static vtk[A-Za-z0-9]*\* New();/d
/^extern template /d
