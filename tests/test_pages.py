"""The README and the pages beside the notebooks: links lead somewhere, and every page is led to."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = sorted((ROOT / "notebooks").glob("*.md"))


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES], ids=lambda page: page.name)
def test_links_lead_to_files(page):
    links = re.findall(r"\]\(([^)#:]+)\)", page.read_text())
    missing = [link for link in links if not (page.parent / link).exists()]
    assert not missing


def test_the_front_page_is_one_page_and_leads_to_all_others():
    front = (ROOT / "README.md").read_text()
    assert front.count("\n") <= 150
    assert len(PAGES) > 8
    assert not [page.name for page in PAGES if f"](notebooks/{page.name})" not in front]
