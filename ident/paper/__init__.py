"""The paper's comparison of identification methods, Section 4: its Table 2 and Figures 3 and 6 to 10."""
