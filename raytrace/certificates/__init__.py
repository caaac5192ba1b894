"""Certified images: bounds of every pixel, and whether an image keeps them."""

from raytrace.certificates.certificate import PRECISIONS, Certificate, certify, read_certificate
from raytrace.certificates.verify import Verification, verify

__all__ = ["PRECISIONS", "Certificate", "Verification", "certify", "read_certificate", "verify"]
