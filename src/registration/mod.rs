//! A patient's face: the standard face matched to a scan.
