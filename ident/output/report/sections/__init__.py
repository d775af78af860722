"""What the report says, section by section. Each function makes one section from the material."""
