//! Results to look at and to open elsewhere: the page, the plots, scenes for other programs.
