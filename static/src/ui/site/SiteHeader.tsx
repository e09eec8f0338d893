import type { ComponentChildren } from "preact";
import { Button } from "../Button";
import { isDark, theme } from "../browser/theme";
import { Icon } from "../Icon";
import { SITE_PAGES } from "./sitePages";

/** Switch between light and dark; a choice equal to the device's scheme is stored as "system". */
function ThemeToggle() {
  const dark = isDark.value;
  return (
    <Button
      kind="quiet"
      icon={dark ? "sun" : "moon"}
      label={dark ? "Light colours" : "Dark colours"}
      onClick={() => {
        const chosen = dark ? "light" : "dark";
        const device = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
        theme.value = chosen === device ? "system" : chosen;
      }}
    />
  );
}

/** Whether this page stands within another one: a slide, or the speaker's window. */
const isFramed = parent !== window;
document.documentElement.classList.toggle("framed", isFramed);

interface SiteHeaderProps {
  readonly current: "home" | "lecture" | "lab" | "logs" | "puzzles" | "none";
  readonly links?: boolean;
  readonly children?: ComponentChildren;
}

/**
 * The header of every page, with a link to its content, which has the id `main`. A page within a slide has none.
 * `children` come before the choice of the colours; without `links` it leads nowhere.
 */
export function SiteHeader({ current, links = true, children }: SiteHeaderProps) {
  if (isFramed) return null;
  return (
    <header class="site-header">
      <a class="skip-link" href="#main">
        Skip to the content
      </a>
      <a class="site-brand" href="/" {...(current === "home" ? { "aria-current": "page" } : {})}>
        <Icon name="logo" />
        <span>Gridbloom</span>
      </a>
      {links && (
        <nav aria-label="Pages">
          {SITE_PAGES.map((page) => (
            <a key={page.id} href={page.href} {...(page.id === current ? { "aria-current": "page" } : {})}>
              {page.label}
            </a>
          ))}
        </nav>
      )}
      {children}
      <ThemeToggle />
    </header>
  );
}
