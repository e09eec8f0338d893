import { Button } from "./Button";
import { isDark, theme } from "./browser/theme";

/** Switch between light and dark; a choice equal to the device's scheme is stored as "system". */
export function ThemeToggle() {
  const dark = isDark.value;
  return (
    <Button
      kind="quiet"
      icon={dark ? "sun" : "moon"}
      label={dark ? "Light colours" : "Dark colours"}
      onClick={() => {
        const wanted = dark ? "light" : "dark";
        const device = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
        theme.value = wanted === device ? "system" : wanted;
      }}
    />
  );
}
