//! DICOM folders and files, against what pydicom and SimpleITK see.
